0 BEGIN PGM MORSEMILL MM
1 ; part: two-peaks.stl [65 x 65 x 20 mm]
2 ; tool: ball:6, tip at program Z
3 ; error budget: facets 2 um, chord 1 um, rounding 0.5 um, cusp 20 um,
4 ; everything together 23.5 um
5 CYCL DEF 32.0 TOLERANCE
6 CYCL DEF 32.1 T0.005
7 TOOL CALL 1 Z
8 L Z+5 R0 FMAX
9 TOOL CALL Z S18000
10 M3
11 ; peak 1
12 L X+1 Y+2 R0 FMAX
13 L Z+0.5 R0 FMAX
14 L Z-1 F500
15 L X+10 Z-1.25 F1500
16 L Y+3
17 L Y+3.5 Z-1.3
18 L X+1 Z-1.063
19 L Z+5 R0 FMAX
20 ; pit 2
21 L X-20 R0 FMAX
22 L Z-2 F500
23 L Y+8 F1500
24 L Z+1 R0 FMAX
25 L Z+5 R0 FMAX
26 M5
27 M9
28 M30
29 END PGM MORSEMILL MM
