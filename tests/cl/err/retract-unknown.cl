$$ 6:1 RETRCT is refused: the height to rise to is not known: write CLEARP/XYPLAN,z before it, or RAPID and GOTO
UNITS/MM
FEDRAT/100,MMPM
RAPID
GOTO/5,0,0
RETRCT
