$$ 6:7 found ';' where a word, a number or a comma should stand
UNITS/MM
FEDRAT/100,MMPM
RAPID
GOTO/5,0,0
GOTO/1;2;3
