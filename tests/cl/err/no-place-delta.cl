$$ 4:1 GODLTA stands before any place is known: put FROM/x,y,z (where the tool stands) or RAPID and a GOTO before it
UNITS/MM
FEDRAT/100
GODLTA/1,2,3
