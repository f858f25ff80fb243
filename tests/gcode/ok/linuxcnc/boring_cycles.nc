(G82 and G86 dwell P seconds; G85 feeds out to R and rapids on, G89 feeds out all the way)
G21 G90 G0 Z5
M3 S500
G98 G82 X1 Z-1 R1 P0.5 F60
G85 X2 Z-1 R1
G86 X3 Z-1 R1 P0.25
G89 X4 Z-1 R1 P2
G80
M5
M2
