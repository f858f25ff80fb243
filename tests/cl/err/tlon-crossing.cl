$$ 7:12 the arc ends at X0.0000 Y5.0000 by the crossing it names, and not at the line's second point: write 2,INTOF behind ON where the arc passes the line once
UNITS/MM
FEDRAT/100,MMPM
RAPID
GOTO/5,0,0
INDIRV/0,1,0
TLON,GOFWD/(CIRCLE/0,0,0,5),ON,(LINE/0,0,0,0,-5,0)
