; 4:4 DC is not supported: it is for rotary axes; write AC or IC
; 5:10 a closing parenthesis is expected here: correct the expression
; 6:6 AC is not a known variable, function or address: define it with DEF, or correct it
G0 X=DC(5)
G0 X=AC(5
G0 X=AC 5
