(pecks of 4: out to R, back to 1 above the last depth)
G21 G90 G0 Z5
G99 G83 X1 Y1 Z-9 R1 Q4 F60
M2
