; 2:1 the program does not open with BEGIN PGM, name and MM (or INCH): its units are unknown, add that block
L X+10 FMAX
BEGIN PGM P MM
END PGM P MM
