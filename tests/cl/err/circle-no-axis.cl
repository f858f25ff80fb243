$$ 6:8 the arc's axis is 0, 0, 0: arcs about X, Y or Z can be posted; output points instead
UNITS/MM
FEDRAT/100,MMPM
RAPID
GOTO/5,0,0
CIRCLE/0,0,0,0,0,0,5
