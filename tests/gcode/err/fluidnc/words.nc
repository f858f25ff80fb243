; 6:7 H is not a word of this controller (three axes, X Y Z): remove it
; 7:1 found '/' where a word (a letter and a number) should begin: a slash that skips the line stands at its very front; move or remove it
; 8:1 G90.1 is not a command of this controller: remove it, or post the program for this dialect
; 9:7 E is not a word of this controller (three axes, X Y Z): remove it
; 10:1 this move has no feed rate: put an F word at or before the first cutting move (in G93: on every line)
G0 X1 H5
/G0 X1
G90.1
G0 X1 E2
G1 X5
