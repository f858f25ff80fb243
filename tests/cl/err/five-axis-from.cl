$$ 3:6 the tool axis is 1, 0, 0: this is 5-axis data, and only 0, 0, 1 (three axes) can be posted; output the operation with a fixed Z axis
UNITS/MM
FROM/0,0,9,1,0,0
