; 12:1 LBL needs a number from 0 to 65535, or a name in quotation marks: add it
; 13:1 LBL needs a number from 0 to 65535, or a name in quotation marks: add it
; 14:10 CALL LBL needs a label: a number from 1 to 65535, or a name in quotation marks: add it
; 15:9 CALL LBL needs a label: a number from 1 to 65535, or a name in quotation marks: add it
; 16:15 REP has no number: write sign and digits, or a Q parameter, behind it
; 17:16 REP takes a whole number from 0 to 65534: correct it
; 18:12 REP takes the same number before and behind the slash: correct it
; 19:1 CALL PGM is not supported: another file is not read; write its blocks into this one, as a subprogram
; 20:6 CALL needs LBL: add it
; 21:12 "TIMES" is not understood here: correct it, or post the program again
BEGIN PGM P MM
LBL
LBL 99999
CALL LBL 0
CALL LBL
CALL LBL 1 REP
CALL LBL 1 REP -2
CALL LBL 1 REP 5/3
CALL PGM OTHER
CALL SUB 1
CALL LBL 1 TIMES 2
END PGM P MM
