$$ 2:7 UNITS does not take CM (did you mean MM?): it takes MM, INCH or INCHES
UNITS/CM
