$$ 4:6 GOTO stands before any place is known: put FROM/x,y,z (where the tool stands) or RAPID and a GOTO before it
UNITS/MM
FEDRAT/100
GOTO/1,2,3
