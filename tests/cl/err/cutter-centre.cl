$$ 3:12 the points are said to be the tool's centre: output the tool tip (its lowest point) in the CAM system
UNITS/MM
CUTTER/6,3,CENTRE
