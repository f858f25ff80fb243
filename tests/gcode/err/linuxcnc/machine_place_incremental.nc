; 3:1 G53 does not work in G91 on this control: put G90 on this line
G21 G91
G53 G0 X1
M2
