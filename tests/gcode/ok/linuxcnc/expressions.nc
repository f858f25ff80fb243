G21 G90 G0
X[2**3**2] Y[-2**2] Z[10-4-3]
X[7 mod 4] Y[-1 mod 4] Z[1 + 2 * 3 gt 6]
X[1 and 0 or 1] Y[2 xor 2] Z[1 eq 1.0000001]
Xfix[-2.8] Yfup[-2.8] Zround[-2.5]
X[atan[-1]/[0]] Y abs[-3] Z-sqrt[4]
G[0+1] F100 X+[1]
M2
