; Centroid CNC12 Operator's Manual, G4: X stands in for P
G21 G90
G4 X2.5
G0 X1
M2
