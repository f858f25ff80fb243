$$ 2:8 TLAXIS has 2 numbers here and takes 3 (i, j, k)
TLAXIS/0,1
