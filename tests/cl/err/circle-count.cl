$$ 6:8 CIRCLE has 8 numbers here and takes 7 (centre, axis, radius), or 11 as NX writes it
UNITS/MM
FEDRAT/100,MMPM
RAPID
GOTO/5,0,0
CIRCLE/0,0,0,0,0,1,5,1
