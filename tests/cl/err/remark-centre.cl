$$ 3:3 the points are said to be the tool's centre: output the tool tip (its lowest point) in the CAM system
UNITS/MM
  $$ POINTS ARE OUTPUT AT BALL CENTER
