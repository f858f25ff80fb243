$$ 2:1 P1 is refused: geometry needs an APT processor: output CL data, not the part program
P1 = POINT/1,2,3
