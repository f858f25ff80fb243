; 7:13 EQU is expected here: correct the formula
; 8:25 GOTO LBL is expected here: correct the formula
; 9:8 IF is expected here: correct the formula
; 10:29 GOTO LBL needs a label: a number from 1 to 65535, or a name in quotation marks: add it
; 11:1 IF is not supported: write FN 9 to FN 12 with GOTO LBL
BEGIN PGM P MM
FN 9: IF +1 GT +2 GOTO LBL 1
FN 9: IF +1 EQU +2 GOTO 1
FN 11: +1 GT +2 GOTO LBL 1
FN 12: IF +1 LT +2 GOTO LBL 0
IF Q1 EQU 5
END PGM P MM
