; specimen: 10 mm square, 2 mm deep
; tool 1: ball 6 mm [tip programmed]
G21
G17
G90
G54
G55
G0 Z25
M3 S12000
G4 S2
; lines
G0 X10 Y0
G0 Z2
G1 Z-1 F300
G1 Y5.5 Z-1.125 F1200
G1 Y0 Z-1
; arcs
G3 X0 Y10 I-10 F600
G2 X10 Y0 Z-2 J-10
G3 X10 Y0 I-10
G4 S1
G0 Z25
M5
