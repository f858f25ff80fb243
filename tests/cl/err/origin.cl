$$ 3:1 ORIGIN is refused: it shifts all points, and systems differ in which way: output them in the machining system, with 0, 0, 0
UNITS/MM
ORIGIN/0,0,5
