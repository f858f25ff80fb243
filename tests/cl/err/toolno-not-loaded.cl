$$ 9:6 TOOLNO/5 on line 8 names another tool than the one in the spindle, and no LOADTL/5 puts it in before this move: write LOADTL/5
UNITS/MM
LOADTL/4
SPINDL/5000,RPM,CLW
FEDRAT/300,MMPM
RAPID
GOTO/0,0,20
TOOLNO/5,10
GOTO/0,0,-1
FINI
