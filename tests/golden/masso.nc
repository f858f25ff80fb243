(part: two-peaks.stl [65 x 65 x 20 mm])
(tool: ball:6, tip at program Z)
(error budget: facets 2 um, chord 1 um, rounding 0.5 um, cusp 20 um, everything together 23.5 um)
G21 G17 G90 G94 G54
G40 G49 G80
G64
T1 M6
G43 H1
G0 Z5
M3 S18000
G4 P3000
(peak 1)
G0 X1 Y2
Z0.5
G1 Z-1 F500
X10 Z-1.25 F1500
Y3
Y3.5 Z-1.3
X1 Z-1.063
G0 Z5
(pit 2)
X-20
G1 Z-2 F500
Y8 F1500
G0 Z1
Z5
M5
M9
M30
