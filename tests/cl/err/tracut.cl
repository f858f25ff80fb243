$$ 2:1 TRACUT is refused: it transforms all points and needs an APT processor: output them transformed
TRACUT/M1
