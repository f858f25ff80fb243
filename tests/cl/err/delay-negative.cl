$$ 2:7 DELAY: -1 must be zero or above, and below a million
DELAY/-1
