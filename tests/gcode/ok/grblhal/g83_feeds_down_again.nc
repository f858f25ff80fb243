(motion_control.c: a quarter of a second behind each peck, then out to the level of G98, and down again at feed)
G21 G90
G0 Z5
G98 G83 X1 Y1 Z-3 R1 Q2 F60
G80
M2
