; 5:1 the drilling cycle needs Q (the depth of a peck): add it
; 6:1 the bottom of the hole, Z 5.0000 mm, is above the R level, 1.0000 mm: correct Z or R
; 8:1 axis words while no motion mode is active (G80): put G0, G1, G2 or G3 on this line
G0 Z5 F100
G83 X1 Z-5 R1
G81 X1 Z5 R1
G80
X1
