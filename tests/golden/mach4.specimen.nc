(specimen: 10 mm square, 2 mm deep)
(tool 1: ball 6 mm [tip programmed])
G21 G17 G90 G94 G54
G40 G49 G80
G91.1
G64
G55
T1 M6
G43 H1
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
M1
M0
(tool 2)
M5
M9
G17
T2 M6
G43 H2
G0 Z25
M4 S8000
G4 P2
M8
M7
M8
G0 X0 Y0
Z1
G1 Z-0.5 F150
G0 Z25
M5
M9
M30
