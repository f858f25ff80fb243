$$ 7:1 found '5' where a comma and another value, or the statement's end, should stand
UNITS/MM
FEDRAT/100,MMPM
RAPID
GOTO/5,0,0
GOTO/1,2$
5,3
