; 4:5 O1 begins on line 2, above its M98: this controller wants numbered programs below it
o1
G0 X1
M98 P1
M2
