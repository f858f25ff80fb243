$$ 7:6 the feed (line 5) is per revolution and the spindle's speed is not known here: put SPINDL/ before this move, or give the feed per minute
UNITS/MM
RAPID
GOTO/0,0,0
FEDRAT/.1,MMPR

GOTO/1,0,0
