; 7:7 D is refused: D names a cutter radius, and compensation is not supported; remove it
; 8:1 this move has no feed rate: put an F word at or before the first cutting move (in G93: on every line)
; 9:1 G92 needs at least one of X Y Z: add it
; 10:1 G10 is refused: here it writes the control's own tables and parameters; set them at the control
; 11:1 G4 needs a P or X (seconds) word: add it
; 12:1 G91.2 is not a command of this controller: remove it, or post the program for this dialect
G0 X1 D1
G1 X5
G92
G10 L2 P1 X0
G4
G91.2
