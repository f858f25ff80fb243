$$ 2:1 the points are said to be the tool's centre: output the tool tip (its lowest point) in the CAM system
PPRINT OUTPUT: TOOL CENTER
