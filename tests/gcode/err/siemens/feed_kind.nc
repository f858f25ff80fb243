; 3:5 this move has no feed rate: put an F word at or before the first cutting move (in G93: on every line)
G1 X10 F100
G95 X20
