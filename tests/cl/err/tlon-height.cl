$$ 7:12 start and end of this arc are not at one height, which this form cannot say: use CIRCLE or MOVARC with GOTO
UNITS/MM
FEDRAT/100,MMPM
RAPID
GOTO/5,0,0
INDIRV/0,1,0
TLON,GOFWD/(CIRCLE/0,0,0,5),ON,(LINE/0,0,-1,0,5,-1)
