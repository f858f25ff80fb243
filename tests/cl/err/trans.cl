$$ 3:1 TRANS is refused: it shifts all points, and systems differ in which way: output them in the machining system, with 0, 0, 0
UNITS/MM
TRANS/1,0,0
