$$ 6:1 GOTA is not known (did you mean GOTO?): remove the line if it moves and switches nothing, or write it in words of ISO 4343
UNITS/MM
FEDRAT/100,MMPM
RAPID
GOTO/5,0,0
GOTA/1,2,3
