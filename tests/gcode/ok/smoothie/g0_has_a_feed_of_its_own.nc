; Smoothieware: F of a G0 line is the speed of rapids alone
G21 G90
G1 X1 F200
G0 X5 F4000
G1 X6
G4 S1
M5
M2
