(Fräser ø 6)
G21 G90G0 X1 ; °µ
M2
