$$ 6:18 GOTO has 7 numbers here and takes 3 (x, y, z), or 6 with the tool axis 0, 0, 1
UNITS/MM
FEDRAT/100,MMPM
RAPID
GOTO/5,0,0
GOTO/1,5,2,5,3,5,0
