; 2:8 G95 needs a turning spindle (S and M3) before it cuts: add it
G95 G1 X10 F0.1
