$$ 2:8 COOLNT does not take FLOD (did you mean FLOOD?): it takes FLOOD, MIST, ON or OFF
COOLNT/FLOD
