$$ 6:11 found ')' where no closing bracket should stand
UNITS/MM
FEDRAT/100,MMPM
RAPID
GOTO/5,0,0
GOTO/1,2,3)
