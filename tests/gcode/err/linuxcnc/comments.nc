; 9:7 the comment is not closed: put ) before the end of the line
; 10:9 a comment inside a comment: remove the inner parentheses
; 11:10 P must be a whole number of 1 or more
; 12:5 H must be a whole number of 0 or more
; 13:1 the arc's centre is its start: give the centre by I J K, not zero
; 14:1 the drilling cycle needs Z (the bottom of the hole): add it
; 15:4 the line ends where a value should stand: complete the expression
; 16:5 the bracket is not closed: put ] behind the expression
G0 X1 (not closed
G0 (one (two)) X1
G2 X1 R3 P1.5 F100
G43 H1.5
G2 X0 Z5 I0 F100
G81 X1
#1=
G0 X[1+2
