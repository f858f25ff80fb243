; 2:1 M98 is not a command of this controller: remove it, or post the program for this dialect
M98 P2
M2
O2
M99
