; 7:1 the CYCL DEF before this line is not finished (its line ends with ~): go on with its Q parameters
; 8:3 cycle 200 needs Q206: add it to the CYCL DEF
; 9:1 the CYCL DEF before this line is not finished (its line ends with ~): go on with its Q parameters
BEGIN PGM P MM
CYCL DEF 200 DRILLING ~
  Q200=2 ~
L X+1 FMAX
  Q201=-5
END PGM P MM
