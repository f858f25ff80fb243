; 9:5 X has no number: write sign and digits, or = and an expression, behind it
; 10:7 X stands twice in this block: keep one
; 11:7 ".2" is not understood here: correct it, or post the program again
; 12:4 "Q5" is not understood here: correct it, or post the program again
; 13:7 "?" is not understood here: correct it, or post the program again
; 14:5 a number, an R parameter or a variable is expected here: correct the expression
; 15:1 "(comment)" is not understood here: correct it, or post the program again
; 16:6 X has no number: write sign and digits, or = and an expression, behind it
G0 X
G0 X1 X2
G0 X1..2
G0 Q5
G0 X1 ?
X=5+
(comment)
G0 X-R1
