$$ 6:12 the statement ends where a value behind the last comma should stand
UNITS/MM
FEDRAT/100,MMPM
RAPID
GOTO/5,0,0
GOTO/1,2,3,
