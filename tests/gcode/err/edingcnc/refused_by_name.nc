; 7:1 G52 is refused: how it adds to G92 is not documented here; use G54 to G59.3
; 8:1 G33 is refused: threading ties the feed to the turning spindle; it is no milling move
; 9:1 G41 is refused: cutter compensation moves the path by a radius that stands in the control's table; post the path of the tool centre and use G40
; 10:1 G84 is refused: tapping ties the feed to the turning spindle, which cannot be shown as plain moves; tap by other means
; 11:1 tool number 100 is above 99: use a smaller one
; 12:1 G28.1 is not a command of this controller: remove it, or post the program for this dialect
G52 X1
G33 K1
G41 D1
G84 X1 Z-1 R1
T100
G28.1
