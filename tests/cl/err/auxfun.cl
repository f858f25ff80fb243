$$ 2:8 AUXFUN: 98 is an M code of one controller: only 0 to 5, 7 to 9 and 30 mean the same everywhere; say it in APT words
AUXFUN/98
