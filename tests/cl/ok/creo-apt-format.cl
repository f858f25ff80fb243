PARTNO / X
UNITS / MM
FEDRAT / 300, MMPM
RAPID
GOTO / 0, -8, 2
GOTO / 0, -8, -1
$$ the exit line is any two points of it: here the diagonal, from below
INDIRV / 1, 0, 0
TLON, GOFWD / (CIRCLE / 0, 0, -1, 8), ON, (LINE / -20, 0, -1, 20, 0, -1)
INDIRP / 8, 5, -1
TLON, GOFWD / (CIRCLE / CANON, 0, 0, -1, 0, 0, 1, 8), ON, 1, INTOF, (LINE / 0, -20, -1, 0, 20, -1)
END
FINI
