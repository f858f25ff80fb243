$$ 6:1 found '1' where a word such as GOTO should stand
UNITS/MM
FEDRAT/100,MMPM
RAPID
GOTO/5,0,0
1.0, 2.0, 3.0
