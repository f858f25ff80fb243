; 3:1 from here the program goes round for ever: after a whole round nothing has changed
G0 X1
M99
