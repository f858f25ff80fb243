(specimen: 10 mm square, 2 mm deep)
(tool 1: ball 6 mm [tip programmed])
G21 G17 G90 G94 G54
G55
G0 Z25
M3 S12000
G4 P2
M8
(lines)
G0 X10 Y0
Z2
G1 Z-1 F300
Y5.5 Z-1.125 F1200
Y0 Z-1
(arcs)
G3 X0 Y10 I-10 F600
G2 X10 Y0 Z-2 J-10
G3 X10 Y0 I-10
G18
G2 X8 Z-2 I-1
G4 P1
G0 Z25
M0
G17
M5
M9
M30
