$$ 6:1 CYCLE/DRILL is refused: drilling cycles are not carried out: output the holes as single motions (cycles expanded) in the CAM system
UNITS/MM
FEDRAT/100,MMPM
RAPID
GOTO/5,0,0
CYCLE/DRILL,CLEAR,3.0,FEDTO,-10.0,MMPM,250.
