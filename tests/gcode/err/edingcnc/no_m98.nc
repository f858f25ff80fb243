; 2:1 M98 is refused: subprograms are called by GOSUB here, which is not read; write their moves out
M98 P2
M2
O2
M99
