; 7:22 cycle 200 needs Q206: add it to the CYCL DEF
; 8:30 Q200 stands twice in this block: keep one
; 9:30 Q999 is not supported: this reader does not know it in this cycle; remove it
; 10:23 "Q200" is not understood here: correct it, or post the program again
; 11:28 Q5 is used before it has a value: assign it first, as in FN 0: Q5 = +0
BEGIN PGM P MM
CYCL DEF 200 DRILLING Q200=2 Q201=-5
CYCL DEF 200 DRILLING Q200=2 Q200=2
CYCL DEF 200 DRILLING Q200=2 Q999=2
CYCL DEF 200 DRILLING Q200 2
CYCL DEF 200 DRILLING Q200=Q5
END PGM P MM
