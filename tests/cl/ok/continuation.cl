UNITS/MM
RAPID $$ to the start
GOTO/1,$ this is a remark
$$ a remark between

2,$ $$ and one behind
3
** a starred remark
FEDRAT/$
100,MMPM
GOTO/$
4,5,$
6
END
FINI
