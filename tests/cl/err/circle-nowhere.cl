$$ 4:8 an arc stands before any place is known: put FROM/x,y,z (where the tool stands) or RAPID and a GOTO before it
UNITS/MM
FEDRAT/100
CIRCLE/0,0,0,0,0,1,5
