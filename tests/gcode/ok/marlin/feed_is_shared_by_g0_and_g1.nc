; Marlin: G0 and G1 have one F, and G1 goes on with that of G0
G21
G90
M3 S10000
G4 S2
G0 X10 Y10 F3000
G1 Z-1
G1 X20 F300
G4 P500
M400
G92 X0
M5
