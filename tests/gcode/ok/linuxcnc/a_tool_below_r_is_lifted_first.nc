(the tool is below R: up to R on the spot, and R is the clear level then)
G21 G90
G0 Z1
G98 G81 X5 Z-2 R4 F100
M2
