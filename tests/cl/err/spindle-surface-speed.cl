$$ 2:12 SPINDL is refused: a constant surface speed is of lathes: give the speed by RPM
SPINDL/200,SMM
