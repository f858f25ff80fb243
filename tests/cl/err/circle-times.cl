$$ 7:6 TIMES,2 with an end that is not over the start is read differently by different systems: write the turns as arcs of their own
UNITS/MM
FEDRAT/100,MMPM
RAPID
GOTO/5,0,0
CIRCLE/0,0,0,0,0,1,5,0,0,0,0,TIMES,2
GOTO/0,5,-1
