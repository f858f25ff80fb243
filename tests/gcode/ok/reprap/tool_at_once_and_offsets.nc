; Duet GCode dictionary: T changes at once, M0 ends the job
G21 G90
T2
G59.1
M3 P0 S6000
G0 X1 Y1 F9000
G1 Z-1 F100
G4 P250
M226
M5
M0
