$$ 6:1 FROM is refused: it names another place than the one the tool was moved to: write RAPID and GOTO instead
UNITS/MM
FEDRAT/100,MMPM
RAPID
GOTO/5,0,0
FROM/9,9,9
