$$ 6:8 the arc's start is 5.0000 mm from its centre and its radius is 6.0000 mm: correct one of them
UNITS/MM
FEDRAT/100,MMPM
RAPID
GOTO/5,0,0
CIRCLE/0,0,0,0,0,1,6
