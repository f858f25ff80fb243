(front) G0 X1
G0 X1 (back)
G0 X1 (back) ; more
G0 X2 (one) (two)
G38.3 Z-1 F10
