; 2:1 the archive begins with a subprogram: put the main program (%_N_..._MPF) first
%_N_HOLE_SPF
G0 X1
M17
