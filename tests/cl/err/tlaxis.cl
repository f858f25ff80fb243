$$ 2:9 the tool axis is 0, 1, 0: this is 5-axis data, and only 0, 0, 1 (three axes) can be posted; output the operation with a fixed Z axis
TLAXIS/ 0.0, 1.0, 0.0
