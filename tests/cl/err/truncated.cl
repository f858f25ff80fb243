$$ 6:15 the file ends inside a statement that $ carries on: it is not whole, write it out again
UNITS/MM
FEDRAT/100,MMPM
RAPID
GOTO/5,0,0
GOTO/1.25,2.5,$
