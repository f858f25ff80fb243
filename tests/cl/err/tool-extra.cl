$$ 2:10 LOADTL does not take TOOLX: it takes a tool number, ADJUST, OSETNO, LENGTH, MANUAL or AUTO
LOADTL/5,TOOLX,3
