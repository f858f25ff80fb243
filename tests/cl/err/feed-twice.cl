$$ 3:10 FEDRAT has 2 numbers here and takes one
UNITS/MM
FEDRAT/1,2
