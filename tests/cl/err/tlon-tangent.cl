$$ 7:12 the direction given before does not run along this circle at its start: correct it
UNITS/MM
FEDRAT/100,MMPM
RAPID
GOTO/5,0,0
INDIRV/1,0,0
TLON,GOFWD/(CIRCLE/0,0,0,5),ON,(LINE/0,0,0,0,5,0)
