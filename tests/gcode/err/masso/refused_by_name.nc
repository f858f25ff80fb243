; 7:1 G38.2 is refused: probing is set up at the control; what it does there is not known here
; 8:1 G28.1 is refused: here it homes the machine (elsewhere it stores a position); home before the program, not in it
; 9:1 M62 is refused: it switches an output or waits for an input; what that does is not known here
; 10:1 M10 is refused: here it clamps or fires something; what is not known here
; 11:1 tool number 105 is above 104: use a smaller one
; 12:5 L is refused: G10 L20 is not there on this control; use L2
G38.2 Z-5 F50
G28.1
M62
M10
T105
G10 L20 P1 X0
