$$ 6:27 the statement ends where a closing bracket should stand
UNITS/MM
FEDRAT/100,MMPM
RAPID
GOTO/5,0,0
TLON,GOFWD/(CIRCLE/0,0,0,5
