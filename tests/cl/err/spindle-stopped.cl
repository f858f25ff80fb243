$$ 10:6 the spindle turned until the tool change on line 7 and nothing starts it again before this cut: put SPINDL/ behind it
UNITS/MM
FEDRAT/100,MMPM
RAPID
GOTO/5,0,0
SPINDL/RPM,900,CLW
LOADTL/2
RAPID
GOTO/0,0,9
GOTO/0,0,0
