; 3:6 a comma stands in a number: write decimals with a dot
; 4:9 a comma stands in a number: write decimals with a dot
G0 X1,5
G0 X1 Y2,25
