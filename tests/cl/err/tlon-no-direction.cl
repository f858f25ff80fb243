$$ 6:12 no INDIRV or INDIRP stands before this arc: its direction is not known
UNITS/MM
FEDRAT/100,MMPM
RAPID
GOTO/5,0,0
TLON,GOFWD/(CIRCLE/0,0,0,5),ON,(LINE/0,0,0,0,5,0)
