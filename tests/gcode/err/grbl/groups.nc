; 6:4 G1 and an earlier word of this line both use the axis words: put them on two lines
; 7:5 G18 and an earlier word of this line belong to the same group (plane): keep one of them
; 8:4 M4 and an earlier word of this line belong to the same group (spindle): keep one of them
; 9:5 G92 and an earlier word of this line both use the axis words: put them on two lines
; 10:7 G53 and an earlier word of this line belong to the same group (commands for one line only): keep one of them
G0 G1 X1
G17 G18
M3 M4
G28 G92 X0
G4 P1 G53
