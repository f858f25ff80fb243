$$ 6:1 CUTCOM/LEFT is refused: cutter compensation by the controller is not posted: output the path of the tool tip, and CUTCOM/OFF
UNITS/MM
FEDRAT/100,MMPM
RAPID
GOTO/5,0,0
CUTCOM/LEFT,1
