; part: two-peaks.stl [65 x 65 x 20 mm]
; tool: ball:6, tip at program Z
; error budget: facets 2 um, chord 1 um, rounding 0.5 um, cusp 20 um, everything together 23.5 um
N10 G710 G17 G40 G90 G94 G54
N20 CYCLE832(0.005,_FINISH,1)
N30 T1
N40 M6
N50 D1
N60 G0 Z5
N70 S18000 M3
N80 G4 F3
; peak 1
N90 G0 X1 Y2
N100 Z0.5
N110 G1 Z-1 F500
N120 X10 Z-1.25 F1500
N130 Y3
N140 Y3.5 Z-1.3
N150 X1 Z-1.063
N160 G0 Z5
; pit 2
N170 X-20
N180 G1 Z-2 F500
N190 Y8 F1500
N200 G0 Z1
N210 Z5
N220 M5
N230 M9
N240 M30
