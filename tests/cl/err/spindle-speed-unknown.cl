$$ 2:1 the spindle is to start and its speed was never told: write SPINDL/RPM,n,CLW
SPINDL/ON
