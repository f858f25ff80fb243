$$ 3:6 found 'ä' where a word, a number or a comma should stand
UNITS/MM
GOTO/ä
