$$ 3:13 FEDRAT: -5 must be above zero and below 1000 m/min
UNITS/MM
FEDRAT/MMPM,-5
