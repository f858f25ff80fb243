$$ 2:8 the statement ends where a speed, ON or OFF should stand
SPINDL/
