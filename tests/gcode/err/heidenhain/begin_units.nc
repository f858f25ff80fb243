; 3:12 BEGIN PGM needs MM or INCH behind the name: add it
; 4:1 the program does not open with BEGIN PGM, name and MM (or INCH): its units are unknown, add that block
BEGIN PGM P
L X+10 FMAX
