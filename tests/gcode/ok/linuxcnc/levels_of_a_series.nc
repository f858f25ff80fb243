(R raised in a series: the way slants)
G21 G90 G0 Z3
G99 G81 X1 Y1 Z-4 R1 F300
Y2 R2
G98
Y4 R2.8
M2
