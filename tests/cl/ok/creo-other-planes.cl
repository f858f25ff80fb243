UNITS/MM
FEDRAT/100
RAPID
GOTO/0,0,5
$$ right hand about +Y goes from Z to X; about -X from Z to Y
CIRCLE/0,0,0,0,1,0,5
GOTO/5,0,0
RAPID
GOTO/0,0,5
CIRCLE/0,0,0,-1,0,0,5
GOTO/0,5,0
END
FINI
