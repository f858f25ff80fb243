; 7:1 this incremental move follows a new frame or tool length, and machines differ in whether it takes that along: send X to an absolute place first
; 11:5 this incremental move follows a new frame or tool length, and machines differ in whether it takes that along: send Y to an absolute place first
; 14:1 this incremental move follows a new frame or tool length, and machines differ in whether it takes that along: send Z to an absolute place first
; 16:4 this incremental move follows a new frame or tool length, and machines differ in whether it takes that along: send Z to an absolute place first
TRANS X5
G91
X1
Y1
X=AC(0)
X1
G55 Y1
T1 M6
G90 X0 Y0
Z=IC(1)
G0 Z5
D2 Z=IC(-1)
