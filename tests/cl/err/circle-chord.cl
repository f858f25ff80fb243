$$ 8:6 this point lies on the circle of line 6 but 180.0 degrees on: it may end the arc or a straight line across it; write a CIRCLE for each arc, or its points closer together
UNITS/MM
FEDRAT/100,MMPM
RAPID
GOTO/5,0,0
CIRCLE/0,0,0,0,0,1,5
GOTO/-5,0,0
GOTO/5,0,0
