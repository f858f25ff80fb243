; 7:1 G2 needs at least one of X Y Z: add it
; 8:10 no circle of radius 2.0000 mm joins points 5.0000 mm apart: R must be at least half of that
; 10:1 the drilling cycle needs Q (the depth of a peck): add it
; 11:15 the drilling cycle needs a Q above zero: add it
; 12:1 G41 is refused: cutter compensation moves the path by a radius that stands in the control's table; post the path of the tool centre and use G40
F100
G2 I5
G2 X5 Y0 R2
G0 Z5
G83 X1 Z-1 R1
G73 X1 Z-1 R1 Q0
G41
