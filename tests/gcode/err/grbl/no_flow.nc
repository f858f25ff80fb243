; 5:1 M98 is not a command of this controller: remove it, or post the program for this dialect
; 6:1 O is not a word of this controller (three axes, X Y Z): remove it
; 7:1 found '#' where a word (a letter and a number) should begin: variables are not read in this dialect; write the numbers
; 8:4 X has no number: write sign, digits and at most one dot after it (no exponents, variables or expressions)
M98 P1
O1
#1=2
G0 X[1]
