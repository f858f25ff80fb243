; 4:1 this move has no feed rate: put an F word at or before the first cutting move (in G93: on every line)
G21 G90
G0 Z5
G1 X10
X20
F300
X30
