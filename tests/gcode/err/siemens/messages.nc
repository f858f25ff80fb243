; 8:1 MSG needs a text in parentheses and quotation marks: add it
; 9:5 MSG needs a closing quotation mark: add it
; 10:8 one text in quotation marks and a closing parenthesis is expected here: correct the expression
; 11:1 WORKPIECE needs its arguments in parentheses: add it
; 12:12 WORKPIECE needs a closing quotation mark: add it
; 13:14 WORKPIECE needs a closing parenthesis: add it
; 14:10 "?" is not understood here: correct it, or post the program again
MSG
MSG("open)
MSG("A"<<R1)
WORKPIECE
WORKPIECE(,"open)
WORKPIECE((1)
MSG("A") ?
