; 8:6 R1 is used before it has a value: assign it first
; 9:1 an assignment to a variable must stand in a block of its own: put the rest on another line
; 10:2 R takes a number from 0 to 9999: correct it
; 11:1 "R1" is not understood here: correct it, or post the program again
; 12:6 "2" is not understood here: correct it, or post the program again
; 13:3 R2 is used before it has a value: assign it first
; 14:2 R takes a number from 0 to 9999: correct it
G0 X=R1
R1=5 G0 X1
R10000=1
R1
R1=1 2
R[R2]=5
R[1.5]=5
