$$ 6:6 the tool axis is 0.1, 0, 0.99499: this is 5-axis data, and only 0, 0, 1 (three axes) can be posted; output the operation with a fixed Z axis
UNITS/MM
FEDRAT/100,MMPM
RAPID
GOTO/5,0,0
GOTO/1,2,3,.1,0,.99499
