; 2:6 the checksum is 5, the line's own is 62: send the line anew
G0 X1*5
G0 (up) X1
M453
M400 M453
