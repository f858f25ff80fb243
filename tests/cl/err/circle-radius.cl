$$ 6:8 the radius of an arc: -5 must be above zero
UNITS/MM
FEDRAT/100,MMPM
RAPID
GOTO/5,0,0
CIRCLE/0,0,0,0,0,1,-5
