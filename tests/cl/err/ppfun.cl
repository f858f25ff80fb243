$$ 2:1 PPFUN is refused: it speaks to one post-processor only: say it in APT words, or remove it
PPFUN/1,2
