; 2:1 this move has no feed rate: put an F word at or before the first cutting move (in G93: on every line)
CYCLE81(50,0,2,-5)
