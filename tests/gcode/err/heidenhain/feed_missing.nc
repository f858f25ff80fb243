; 3:3 this move has no feed rate: put an F word at or before the first cutting move (in G93: on every line)
BEGIN PGM P MM
L X+10
END PGM P MM
