$$ 2:1 SAFPOS is refused: the safe place is the machine's and is not known here: write RAPID and GOTO with its coordinates
SAFPOS
