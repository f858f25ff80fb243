$$ 4:6 1016000 mm lies beyond 1000 m: no machine is so large, check the number and the UNITS
UNITS/INCH
RAPID
GOTO/40000,0,0
