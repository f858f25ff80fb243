$$ 6:1 ARCSLP is refused: helices by ARCSLP are not read: output MOVARC and GOTO with the height of its end
UNITS/MM
FEDRAT/100,MMPM
RAPID
GOTO/5,0,0
ARCSLP/2
