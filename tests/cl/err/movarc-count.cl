$$ 6:8 MOVARC has 6 numbers here and takes 7 (centre, axis, radius), with ANGLE and a number, or CENTER, AXIS, RADIUS before them
UNITS/MM
FEDRAT/100,MMPM
RAPID
GOTO/5,0,0
MOVARC/0,0,0,0,0,1
