(ä)
G0 XY
M2