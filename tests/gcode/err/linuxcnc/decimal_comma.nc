; 3:6 a comma stands in a number: write decimals with a dot
; 4:5 a comma stands in a number: write decimals with a dot
G0 X1,5
X[1]Y1,5
M2
