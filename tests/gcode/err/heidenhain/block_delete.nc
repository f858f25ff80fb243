; 3:1 / is not supported: whether the operator skips such blocks is not known; write the block without / or remove it
BEGIN PGM P MM
/ L X+1 FMAX
END PGM P MM
