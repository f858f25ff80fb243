; 4:1 M30 is not supported: end a subprogram with M17 or RET
HOLE
%_N_HOLE_SPF
M30
M17
