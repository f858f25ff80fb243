$$ 2:8 SPINDL: -200 rev/min must be zero or above, and below a million; the direction is said by CLW or CCLW
SPINDL/-200,CLW
