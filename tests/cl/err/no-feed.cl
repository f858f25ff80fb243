$$ 5:6 this move has no feed: put FEDRAT/ with a feed, or RAPID, before it
UNITS/MM
RAPID
GOTO/1,2,3
GOTO/2,2,3
