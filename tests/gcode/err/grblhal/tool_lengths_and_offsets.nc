; 7:1 G43.1 takes Z and nothing else: write G43.1 Z and the length
; 8:8 P must be a whole number from 1 to 9 here
; 9:5 H must be a whole number of 0 or more
; 10:6 M7.5 is not a command of this controller, and without its fraction it would mean something else: post the program for this dialect
; 11:1 G59.4 is not a command of this controller, and without its fraction it would mean something else: post the program for this dialect
; 12:8 E is not a word of this controller (three axes, X Y Z): remove it
G43.1 X5
G10 L2 P10 X0
G43 H1.5
T1.5 M7.5
G59.4
/G0 X1 E1
