$$ 2:11 the spindle is to start and its speed was never told: write SPINDL/RPM,n,CLW
DELAY/REV,3
