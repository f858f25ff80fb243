; case, blanks, comments inside words, several words without blanks
g21g90
G0X1.5(a comment)Y 2 . 5
g1 z-.5 f300
x+10
M3S1000
G91 G2 X10 Y0 I5 J0
G4 P1.5
M8
G38.3 Z-5
G90 G53 G0 Z0
M5 M9
M0
M1
M30
