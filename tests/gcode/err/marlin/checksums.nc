; 5:9 the checksum is 96, the line's own is 97: send the line anew
; 6:9 * has no number: write sign, digits and at most one dot after it (no exponents, variables or expressions)
; 7:9 * has no number: write sign, digits and at most one dot after it (no exponents, variables or expressions)
N1 G0 X1*97
N2 G0 X2*96
N3 G0 X3*
N4 G0 X4*1e5
