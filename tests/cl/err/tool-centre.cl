$$ 2:26 the points are said to be the tool's centre: output the tool tip (its lowest point) in the CAM system
TLDATA/MILL,6.0,3.0,50.0,CENTER
