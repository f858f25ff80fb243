; 7:1 G5 is refused: splines are not supported; post lines or arcs
; 8:1 G16 is refused: polar coordinates turn X and Y into radius and angle; post plain coordinates
; 9:1 G51 is refused: it scales the path; post the path as it shall be cut
; 10:1 G76 is refused: this boring cycle orients the spindle and shifts the tool; write its moves out
; 11:1 M62 is refused: it switches an output or waits for an input; what that does is not known here
; 12:7 B is not a word of this controller (three axes, X Y Z): remove it
G5 X1
G16
G51 P2
G76 X1
M62 P1
G0 X1 B5
