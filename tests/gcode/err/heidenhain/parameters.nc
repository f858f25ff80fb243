; 16:5 Q1 is used before it has a value: assign it first, as in FN 0: Q1 = +0
; 17:5 Q100 is not supported: the control sets Q100 to Q199, and what it holds is not known
; 18:5 QL (or QR, QS) is not supported: only Q parameters with a number are read
; 19:7 Q takes a number from 0 to 1999 right behind it: correct it
; 20:7 a Q parameter is expected here: correct the formula
; 21:10 = is expected here: correct the formula
; 22:6 FN needs a colon behind its number: add it
; 23:14 + is expected here: correct the formula
; 24:12 FN 4 (DIV) gives no number here: correct the values
; 25:12 SQRT gives no number here: correct the values
; 26:12 SIN is expected here: correct the formula
; 27:1 FN 14 is not supported: it speaks with the control, not with the tool; remove it
; 28:7 Q110 is not supported: the control sets Q100 to Q199; use another one
; 29:14 "6" is not understood here: correct it, or post the program again
BEGIN PGM P MM
L X+Q1 FMAX
L X+Q100 FMAX
L X+QL1 FMAX
FN 0: Q2000 = 5
FN 0: X = 5
FN 0: Q1 5
FN 0 Q1 = 5
FN 1: Q1 = 5 - 3
FN 4: Q1 = 5 DIV 0
FN 5: Q1 = SQRT -4
FN 6: Q1 = 30
FN 14: ERROR = 5
FN 0: Q110 = 5
FN 0: Q1 = 5 6
END PGM P MM
