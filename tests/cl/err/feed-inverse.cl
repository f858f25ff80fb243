$$ 3:8 FEDRAT does not take INVERS: it takes a number with MMPM, IPM, PERMIN, MMPR, IPR or PERREV, or without
UNITS/MM
FEDRAT/INVERS,5
