(G91: R from the initial level, Z from R; K3 holes)
G21 G90 G0 X0. Y0. Z10.
G91 G98 G81 X5. Z-6. R-8. K3 F80
G80 G90
M30
