$$ 7:12 the line does not cross the circle: the arc has no end
UNITS/MM
FEDRAT/100,MMPM
RAPID
GOTO/5,0,0
INDIRV/0,1,0
TLON,GOFWD/(CIRCLE/0,0,0,5),ON,(LINE/9,0,0,9,5,0)
