; 5:1 G4 needs F with the seconds: add it
; 6:4 G4 S is not supported: write the time in seconds, G4 F
; 7:1 G4 must stand in a block of its own: put the rest on another line
; 8:4 G4 F takes seconds of zero or more: correct it
G4
G4 S10
G4 F1 X5
G4 F-1
