; 7:1 the program ends inside a called subprogram: close it with LBL 0
BEGIN PGM P MM
CALL LBL 1
M30
LBL 1
L X+1 F10
END PGM P MM
