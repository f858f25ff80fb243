$$ 6:1 GOHOME is refused: home is the machine's and is not known here: write RAPID and GOTO with its coordinates
UNITS/MM
FEDRAT/100,MMPM
RAPID
GOTO/5,0,0
GOHOME
