$$ 2:1 OPSKIP/ON is refused: blocks that the operator may leave out are not posted: remove it
OPSKIP/ON
