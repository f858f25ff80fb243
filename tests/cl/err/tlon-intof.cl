$$ 7:32 TLON,GOFWD: 3 INTOF is neither 1 nor 2: an arc crosses a line twice at most
UNITS/MM
FEDRAT/100,MMPM
RAPID
GOTO/5,0,0
INDIRV/0,1,0
TLON,GOFWD/(CIRCLE/0,0,0,5),ON,3,INTOF,(LINE/0,0,0,0,5,0)
