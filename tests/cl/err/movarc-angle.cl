$$ 7:6 ANGLE is 270.0000 degrees, and from start to end the arc turns by 90.0000 degrees about its axis (right hand): turn the axis, or correct the angle
UNITS/MM
FEDRAT/100,MMPM
RAPID
GOTO/5,0,0
MOVARC/0,0,0,0,0,1,5,ANGLE,270
GOTO/0,5,0
