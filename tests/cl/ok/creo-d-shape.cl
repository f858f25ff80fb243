UNITS / MM
FEDRAT / 400, MMPM
RAPID
GOTO / 0, -10, 0
$$ half round in six steps, then straight back along the diameter
CIRCLE / 0, 0, 0, 0, 0, 1, 10
GOTO / 5, -8.660254, 0
GOTO / 8.660254, -5, 0
GOTO / 10, 0, 0
GOTO / 8.660254, 5, 0
GOTO / 5, 8.660254, 0
GOTO / 0, 10, 0
GOTO / 0, -10, 0
END
FINI
