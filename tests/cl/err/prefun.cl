$$ 2:1 PREFUN is refused: it is a G code of one controller: say it in APT words, or remove it
PREFUN/64
