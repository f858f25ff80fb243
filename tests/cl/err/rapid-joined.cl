$$ 4:1 RAPID GOTO is not known: remove the line if it moves and switches nothing, or write it in words of ISO 4343
UNITS/MM
FEDRAT/100,MMPM
RAPID$
GOTO/5,0,0
FINI
