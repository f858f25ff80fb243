$$ 2:6 found '5' where the statement's end should stand
STOP/5
