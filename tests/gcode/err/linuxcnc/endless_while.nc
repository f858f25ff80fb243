; 4:1 from here the program goes round for ever: after a whole round nothing has changed
o1 while [1]
G4 P1
o1 endwhile
