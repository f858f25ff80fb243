(Carbide Motion: the tool is measured at M6)
G90 G21
M6 T201
M3 S18000
G0 X5 Y5 Z10
G1 Z-1 F300
G1 X10 F1000
G0 Z10
M5
M30
