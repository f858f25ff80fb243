; 4:1 the program has no END PGM and no M30 or M2 was reached: the file may be cut off, transfer it again
BEGIN PGM P MM
L X+1 FMAX
