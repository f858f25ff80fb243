$$ 6:6 this number cannot be read: write digits with one dot, as 12.5 or 1.25E+01
UNITS/MM
FEDRAT/100,MMPM
RAPID
GOTO/5,0,0
GOTO/1.2.3,4,5
