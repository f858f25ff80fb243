; 3:10 R is refused: this firmware does not read it, so that the arc would run elsewhere; give the centre by I, J, K
G1 F100
G2 X5 Y5 R5
