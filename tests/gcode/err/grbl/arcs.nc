; 10:1 G2 needs at least one of X Y Z: add it
; 11:1 the arc has no end point in its plane: give one of X Y
; 12:1 the arc has no centre: give I or J, or R
; 13:8 no circle of radius 4.0000 mm joins points 10.0000 mm apart: R must be at least half of that
; 14:10 an arc by R cannot end where it starts: give the centre by I J K for a full circle
; 15:1 the arc starts 5.1000 mm from its centre but ends 4.9000 mm from it: correct I J K or the end point
; 16:5 the arc has no centre: give I or K, or R
; 17:8 nothing in this line uses I: remove it, or add the command it belongs to
F300
G2 I5
G2 Z1 I5
G2 X10
G2 X10 R4
G2 X0 Y0 R4
G2 X10 I5.1
G18 G2 X10 J5
G2 X10 I5 R5
