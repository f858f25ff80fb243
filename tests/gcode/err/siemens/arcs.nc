; 15:4 the arc starts 6.0000 mm from its centre but ends 4.0000 mm from it: correct I J K or the end point
; 16:4 an arc needs its centre (I J K), CR or AR: add it
; 17:8 no circle of radius 10.0000 mm joins points 30.0000 mm apart: correct CR or the end point (full circles are written with I J K)
; 18:10 no circle of radius 10.0000 mm joins points 0.0000 mm apart: correct CR or the end point (full circles are written with I J K)
; 19:11 nothing in this block uses K: remove it, or add the command it belongs to
; 20:11 nothing in this block uses CR: remove it, or add the command it belongs to
; 21:13 TURN takes a whole number from 0 to 999: correct it
; 22:7 TURN in a full circle is not supported: whether one more full circle is meant differs; split it into single circles
; 23:8 AR takes an angle above 0 and below 360 degrees: correct it
; 24:11 nothing in this block uses AR with centre and end point: remove it, or add the command it belongs to
; 25:4 the arc starts 0.0000 mm from its centre but ends 0.0000 mm from it: correct I J K or the end point
; 26:8 nothing in this block uses I: remove it, or add the command it belongs to
; 27:4 nothing in this block uses CR: remove it, or add the command it belongs to
F100
G2 X10 Y0 I6 J0
G2 X10 Y0
G2 X30 CR=10
G2 X0 Y0 CR=10
G2 X10 I5 K1
G2 X10 I5 CR=5
G2 X10 CR=5 TURN=1.5
G2 I5 TURN=1
G2 X10 AR=360
G2 X10 I5 AR=90
G3 X0 Y0 I0 J0
G1 X10 I5
G0 CR=5
