$$ 3:8 FEDRAT: 0 must be above zero and below 1000 m/min
UNITS/MM
FEDRAT/0,MMPM
