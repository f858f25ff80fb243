$$ 2:6 MODE does not take INCR: it takes MILL
MODE/INCR
