; 3:1 END PGM does not name the program that BEGIN PGM opened (P): the file may be two pieces, correct it
BEGIN PGM P MM
END PGM Q MM
