; 6:1 the drilling cycle needs Q (the depth of a peck): add it
; 7:15 nothing in this line uses P: remove it, or add the command it belongs to
; 8:5 G0 and an earlier word of this line both use the axis words: put them on two lines
; 9:1 M6.1 is not a command of this controller, and without its fraction it would mean something else: post the program for this dialect
G0 Z5 F100
G83 X1 Z-5 R1
G81 X1 Z-1 R1 P2
G81 G0 X1 Z-1 R1
M6.1
