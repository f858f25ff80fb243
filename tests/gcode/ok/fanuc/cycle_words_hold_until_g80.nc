(words hold from cycle to cycle; K0 keeps them and drills nothing)
G21 G90 G0 Z30.
G99 G81 Z-4. R2. F100 K0
X10. Y10.
X20.
G98 G82 X30. P500
G80
G0 X0. Y0.
M30
