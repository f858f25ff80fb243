; 7:8 this control reads nothing behind a comment: put the comment at the end of the line
; 8:1 G4 needs a S (whole seconds; P depends on the mode) word: add it
; 9:4 S must be a whole number of 0 or more
; 10:1 T is refused: here it switches to another extruder at once; pause by M0 for a tool change
; 11:7 E is refused: it moves an extruder, and a mill has none; remove it
; 13:1 this move has no feed rate: put an F word at or before the first cutting move (in G93: on every line)
G0 (a) X1
G4 P500
G4 S1.5
T1
G1 X1 E1
G0 X1 F3000
G1 X2
