; 6:1 the IF of line 3 has no ENDIF: add it
R1=1
IF R1>2
G0 X5
M30
