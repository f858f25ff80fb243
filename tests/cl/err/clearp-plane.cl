$$ 3:8 CLEARP does not take ZXPLAN (did you mean XYPLAN?): it takes XYPLAN and a height
UNITS/MM
CLEARP/ZXPLAN,5
