; 3:1 a second BEGIN PGM: keep one program in a file
BEGIN PGM P MM
BEGIN PGM Q MM
END PGM P MM
