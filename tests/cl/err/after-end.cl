$$ 7:1 GOTO stands behind END (line 6): one file is one program, cut it there
UNITS/MM
FEDRAT/100,MMPM
RAPID
GOTO/5,0,0
END
GOTO/1,2,3
