; 14:1 G4 needs a P (seconds) word: add it
; 15:1 G92 needs at least one of X Y Z: add it
; 16:1 G10 needs at least one of X Y Z: add it
; 17:1 G10 needs a P (which offset) and an L (2 or 20) word: add it
; 18:8 G10 P7 names no work offset: use P1 (G54) to P6 (G59), or P0 for the active one
; 19:1 G10 is understood with L2 and L20 only: write one of them
; 20:11 G10 L2 with R would turn the coordinate system, which is not supported: remove R
; 21:1 G43.1 takes Z and nothing else: write G43.1 Z and the length
; 22:7 nothing in this line uses P: remove it, or add the command it belongs to
; 24:1 axis words while no motion mode is active (G80): put G0, G1, G2 or G3 on this line
; 25:1 G53 works with straight moves only: put G0 or G1 on this line
; 26:1 G38 needs at least one of X Y Z: add it
; 27:1 the probe move goes nowhere: give it an end point away from the tool
G4
G92
G10 L2 P1
G10 X1
G10 L2 P7 X1
G10 L3 P1 X1
G10 L2 P1 R5 X1
G43.1 X1
G0 X1 P5
G80
X5
G53 G2 X5
G38.2 F100
G38.2 Z0 F100
