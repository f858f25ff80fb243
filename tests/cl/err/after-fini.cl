$$ 8:1 PARTNO stands behind FINI (line 7): one file is one program, cut it there
UNITS/MM
FEDRAT/100,MMPM
RAPID
GOTO/5,0,0
END
FINI
PARTNO TWO
