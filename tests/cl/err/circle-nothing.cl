$$ 7:6 start and end of this arc are 0.00050 mm apart: it may be once round or nothing at all; give both the same digits, or leave it out
UNITS/MM
FEDRAT/100,MMPM
RAPID
GOTO/5,0,0
CIRCLE/0,0,0,0,0,1,5
GOTO/5,.0005,0
