; 7:4 M6 is not a command of this controller: remove it, or post the program for this dialect
; 8:1 G43 is not a command of this controller: remove it, or post the program for this dialect
; 9:1 G64 is not a command of this controller: remove it, or post the program for this dialect
; 10:1 M7 is not a command of this controller: remove it, or post the program for this dialect
; 11:1 G81 is not a command of this controller: remove it, or post the program for this dialect
; 12:1 O is not a word of this controller (three axes, X Y Z): remove it
T1 M6
G43 H1
G64 P0.01
M7
G81 X1 Y1 Z-1 R1 F100
O100
