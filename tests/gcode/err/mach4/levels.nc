; 5:1 the R level, 1.0000 mm, is above the level that the cycle starts from, 0.0000 mm: rapid higher first
; 7:1 the drilling cycle needs Q (the depth of a peck): add it
; 8:1 G41 is refused: cutter compensation moves the path by a radius that stands in the control's table; post the path of the tool centre and use G40
G0 Z0
G81 X1 Z-1 R1 F100
G0 Z5
G83 X1 Z-1 R1
G41 D1
