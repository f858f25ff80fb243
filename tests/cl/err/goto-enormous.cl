$$ 6:6 3000000 mm lies beyond 1000 m: no machine is so large, check the number and the UNITS
UNITS/MM
FEDRAT/100,MMPM
RAPID
GOTO/5,0,0
GOTO/1,2,3000000
