; 7:1 the subprogram ends without M17 or RET: add it as the last block
%_N_MAIN_MPF
HOLE
M30
%_N_HOLE_SPF
G0 X1
%_N_END_SPF
