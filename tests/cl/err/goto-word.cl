$$ 6:10 found 'T' where the statement's end should stand
UNITS/MM
FEDRAT/100,MMPM
RAPID
GOTO/5,0,0
GOTO/1,2,TOP
