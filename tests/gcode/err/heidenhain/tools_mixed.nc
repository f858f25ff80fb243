; 4:11 the program calls tools by name and by number: which is which cannot be known, keep to one of them
BEGIN PGM P MM
TOOL CALL "MILL" Z
TOOL CALL 2 Z
END PGM P MM
