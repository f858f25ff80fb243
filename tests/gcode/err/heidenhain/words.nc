; 8:7 X has no number: write sign and digits, or a Q parameter, behind it
; 9:8 X stands twice in this block: keep one
; 10:8 "Q5" is not understood here: correct it, or post the program again
; 11:8 ".3" is not understood here: correct it, or post the program again
; 12:1 "HELLO" is not understood here: correct it, or post the program again
; 13:1 "X+10" is not understood here: correct it, or post the program again
BEGIN PGM P MM
12 L X
L X+10 X+5 FMAX
L X+10 Q5
L X+1.2.3 FMAX
HELLO
X+10 R0 F100
END PGM P MM
