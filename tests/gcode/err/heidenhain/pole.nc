; 9:2 C turns about the pole, and none is set: put a CC block before it
; 10:3 LP turns about the pole, and none is set: put a CC block before it
; 11:3 CP turns about the pole, and none is set: put a CC block before it
; 12:4 CC needs both X and Y (or neither, for the last position): add it
; 13:4 CC with Z is not supported: arcs are read in X and Y only; post this one as lines
; 14:12 "F" is not understood here: correct it, or post the program again
; 15:12 "M3" is not understood here: correct it, or post the program again
BEGIN PGM P MM
C X+0 Y+10 DR+ F100
LP PR+10 PA+0 FMAX
CP IPA+90 DR+ F100
CC X+1
CC Z+1 X+1
CC X+1 Y+1 F5
CC X+1 Y+1 M3
END PGM P MM
