O1 G0
O2 (two)
O2
