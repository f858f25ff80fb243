$$ 2:8 LOADTL does not take DRILL: it takes a tool number
LOADTL/DRILL
