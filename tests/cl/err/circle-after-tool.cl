$$ 7:8 the arc follows the tool change on line 6: bring the tool to its start by a GOTO first
UNITS/MM
FEDRAT/100,MMPM
RAPID
GOTO/5,0,0
LOADTL/2
CIRCLE/0,0,0,0,0,1,5
