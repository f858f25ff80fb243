; 4:1 from here the program goes round for ever: after a whole round nothing has changed
o1 do
G0 X1
o1 while [1]
