$$ 3:12 FEDRAT does not take MMPN (did you mean MMPM?): it takes a number with MMPM, IPM, PERMIN, MMPR, IPR or PERREV, or without
UNITS/MM
FEDRAT/100,MMPN
