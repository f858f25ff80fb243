; 3:47 the formula is nested too deeply: split it over several Q parameters
BEGIN PGM P MM
Q1 = ((((((((((((((((((((((((((((((((((((((((((((((((((1))))))))))))))))))))))))))))))))))))))))))))))))))
END PGM P MM
