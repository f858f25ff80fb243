; 12:4 X has no number: write sign, digits and at most one dot after it (no exponents, variables or expressions)
; 13:8 found '.' where a word (a letter and a number) should begin: remove it
; 14:10 X stands twice in this line: keep one
; 15:1 F must not be negative: write a value of zero or more
; 16:7 A is not a word of this controller (three axes, X Y Z): remove it
; 17:1 G1.5 is not a command of this controller, and without its fraction it would mean something else: post the program for this dialect
; 18:1 G99 is not a command of this controller: remove it, or post the program for this dialect
; 19:1 the line number is above 10000000: use a smaller N, or none
; 20:9 found '#' where a word (a letter and a number) should begin: variables are not read in this dialect; write the numbers
; 21:1 tool number 300 is above 255: use a smaller one
; 22:1 the line has 82 characters, this controller reads at most 79: split it
G0 X
G0 X1.2.3
G0 X1 Y2 X3
F-100
G0 X1 A5
G1.5 X1
G99
N10000001 G0
  G0 X1 #2
T300
G1 X0000000000000000000000000000000000000000000000000000000000000000000000000000001
