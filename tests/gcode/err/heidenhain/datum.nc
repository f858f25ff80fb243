; 11:14 a datum from the table is not supported: the table is not read; write the shift itself (7.1 X.. 7.2 Y.. 7.3 Z..)
; 12:13 CYCL DEF 7 needs X, Y or Z with the shift: add it
; 13:14 "A+5" is not understood here: correct it, or post the program again
; 14:1 TRANS is not supported: write TRANS DATUM AXIS or CYCL DEF 7
; 15:1 TRANS is not supported: write TRANS DATUM AXIS or CYCL DEF 7
; 16:27 Q339 takes a preset from 1 to 99: correct it
; 17:20 CYCL DEF 9.1 takes seconds from 0 to 3600: correct it
; 18:19 CYCL DEF 9.1 has no number: write sign and digits, or a Q parameter, behind it
; 19:15 T takes a tolerance of zero or more: correct it
BEGIN PGM P MM
CYCL DEF 7.1 #5
CYCL DEF 7.1
CYCL DEF 7.1 A+5
TRANS DATUM TABLE TABLINE5
TRANS MIRROR AXIS X
CYCL DEF 247 DATUM SETTING Q339=100
CYCL DEF 9.1 DWELL 5000
CYCL DEF 9.1 DWELL
CYCL DEF 32.1 T-0.1
END PGM P MM
