$$ 6:1 ARC is refused: its numbers mean different things in different systems: output arcs as CIRCLE or MOVARC
UNITS/MM
FEDRAT/100,MMPM
RAPID
GOTO/5,0,0
ARC/0,0,0,5
