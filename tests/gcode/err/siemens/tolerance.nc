; 5:1 CYCLE832 needs its arguments in parentheses: add it
; 6:1 CYCLE832 takes a tolerance of zero or more: correct it
; 7:14 _ORI_FINISH is not supported: it is for machines of five axes; give _FINISH, _SEMIFIN, _ROUGH or _OFF
; 8:13 a comma or a closing parenthesis is expected here: correct the expression
CYCLE832
CYCLE832(-1,_FINISH)
CYCLE832(0.1,_ORI_FINISH,1)
CYCLE832(0.1
