; 12:13 TOOL CALL is not supported: the tool axis must be Z
; 13:1 TOOL CALL needs a tool number, or S: add it
; 14:15 S takes a number of zero or more: correct it
; 15:15 DR is not supported: it changes the tool by an amount that moves the path; write it into the program's path
; 16:11 TOOL CALL takes a tool number from 0 to 32767: correct it
; 17:11 TOOL CALL needs a closing quotation mark behind the name: add it
; 18:20 S stands twice in this block: keep one
; 19:15 "P5" is not understood here: correct it, or post the program again
; 20:6 TOOL needs CALL or DEF: add it
; 21:9 TOOL DEF has no number: write sign and digits, or a Q parameter, behind it
BEGIN PGM P MM
TOOL CALL 1 X S1000
TOOL CALL
TOOL CALL 1 Z S-5
TOOL CALL 1 Z DR+0.1
TOOL CALL 1.5 Z
TOOL CALL "MILL Z
TOOL CALL 1 Z S100 S200
TOOL CALL 1 Z P5
TOOL CHANGE
TOOL DEF
END PGM P MM
