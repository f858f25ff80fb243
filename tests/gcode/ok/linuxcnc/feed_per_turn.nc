(G95: mm a turn times turns a minute)
G21 G90 G95
M3 S1000
G1 X10 F0.1
S2000
X20
G94 F300 X30
M2
