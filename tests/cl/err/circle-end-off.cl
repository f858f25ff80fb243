$$ 7:6 the arc's end is 5.1000 mm from its centre and its radius is 5.0000 mm: correct one of them
UNITS/MM
FEDRAT/100,MMPM
RAPID
GOTO/5,0,0
CIRCLE/0,0,0,0,0,1,5
GOTO/0,5.1,0
