$$ 6:1 GOLFT is refused: drive surfaces need an APT processor: output points or CIRCLE
UNITS/MM
FEDRAT/100,MMPM
RAPID
GOTO/5,0,0
GOLFT/L1,PAST,C1
