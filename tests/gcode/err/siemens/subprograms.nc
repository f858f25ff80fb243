; 10:1 CALL is not supported: another file is not read; put the subprogram into this archive and call it by its name
; 11:1 EXTCALL is not supported: another file is not read; put the subprogram into this archive and call it by its name
; 12:1 POCKET is not supported: a cycle or subprogram with arguments is not read; post the motions themselves
; 13:5 "X5" is not understood here: correct it, or post the program again
; 14:1 PROC with parameters is not supported: use R parameters
; 15:11 SAVE is not supported: this reader does not carry it out; remove it
; 16:1 PROC needs the subprogram's name: add it
; 17:5 "5" is not understood here: correct it, or post the program again
; 18:4 HOLE is not a known variable, function or address: define it with DEF, or correct it
CALL "OTHER"
EXTCALL "BIG"
POCKET(5,6)
L10 X5
PROC PART(REAL LENGTH)
PROC PART SAVE
PROC
RET 5
G0 HOLE
