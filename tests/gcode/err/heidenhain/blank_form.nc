; 6:5 BLK needs FORM: add it
; 7:10 "" is not understood here: correct it, or post the program again
; 8:14 BLK FORM is not supported: the tool axis must be Z
; 9:14 "A" is not understood here: correct it, or post the program again
BEGIN PGM P MM
BLK SHAPE
BLK FORM 0.3 X+0
BLK FORM 0.1 X X+0 Y+0 Z+0
BLK FORM 0.2 A+0
END PGM P MM
