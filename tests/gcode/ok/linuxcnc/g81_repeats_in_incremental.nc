(G91: R from where the tool is, Z from R, X and Y from hole to hole)
G21 G90 G0 X1 Y2 Z3
G91 G99 G81 X4 Y5 Z-0.6 R-1 L3 F100
G80 G90
M2
