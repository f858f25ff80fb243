; 2:4 this move has no feed rate: put an F word at or before the first cutting move (in G93: on every line)
G1 X10
