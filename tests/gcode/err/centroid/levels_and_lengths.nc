; 5:1 the R level, 1.0000 mm, is above the level that the cycle starts from, 0.0000 mm: rapid higher first
; 6:1 the tool length needs a H (which length) word: add it
; 7:1 G86 is not a command of this controller: remove it, or post the program for this dialect
G0 Z0
G81 X1 Z-1 R1 F100
G43 Z5
G86 Z-1 R0
