$$ 2:1 ROTABL is refused: a rotary table turns the part: this is data for more than three axes; output each side as a file of its own
ROTABL/90,CLW
