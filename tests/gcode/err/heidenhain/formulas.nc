; 13:8 the product or quotient gives no number here: correct the values
; 14:13 a closing parenthesis is expected here: correct the formula
; 15:9 a number or a Q parameter is expected here: correct the formula
; 16:6 "FOO" is not understood here: correct it, or post the program again
; 17:6 SQRT gives no number here: correct the values
; 18:6 LN gives no number here: correct the values
; 19:10 a base in parentheses when it has a sign is expected here: correct the formula
; 20:12 a pair of parentheses around one of the powers is expected here: correct the formula
; 21:8 the power gives no number here: correct the values
; 22:6 Q1 is used before it has a value: assign it first, as in FN 0: Q1 = +0
; 23:1 QS is not supported: only Q parameters with a number are read
BEGIN PGM P MM
Q1 = 5 / 0
Q1 = ( 5 + 3
Q1 = 5 +
Q1 = FOO 5
Q1 = SQRT - 4
Q1 = LN 0
Q1 = - 2 ^ 2
Q1 = 2 ^ 3 ^ 2
Q1 = 9 ^ 999
Q1 = Q1 + 1
QS1 = 5
END PGM P MM
