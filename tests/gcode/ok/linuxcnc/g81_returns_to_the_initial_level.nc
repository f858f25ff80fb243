(LinuxCNC manual, G81: rapid at the level of the start, rapid to R, feed to Z, rapid out)
G21 G90 G17 G94
G0 Z10
G98 G81 X5 Y6 Z-3 R2 F120
X15
G80
M2
