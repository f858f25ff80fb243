$$ 2:16 SPINDL does not take CWL (did you mean CLW?): it takes a speed with RPM, CLW or CCLW in any order, or ON or OFF
SPINDL/RPM,200,CWL
