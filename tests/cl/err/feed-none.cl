$$ 3:12 the statement ends where a feed should stand
UNITS/MM
FEDRAT/MMPM
