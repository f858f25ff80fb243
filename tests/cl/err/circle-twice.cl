$$ 7:1 the arc on line 6 has no end: a GOTO must follow it
UNITS/MM
FEDRAT/100,MMPM
RAPID
GOTO/5,0,0
CIRCLE/0,0,0,0,0,1,5
CIRCLE/0,0,0,0,0,1,5
