$$ 7:8 RAPID stands before an arc: controllers have arcs at feed only, remove RAPID
UNITS/MM
FEDRAT/100,MMPM
RAPID
GOTO/5,0,0
RAPID
CIRCLE/0,0,0,0,0,1,5
