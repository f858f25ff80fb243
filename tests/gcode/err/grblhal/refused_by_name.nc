; 8:1 G5 is refused: splines are not supported; post lines or arcs
; 9:1 G33 is refused: threading ties the feed to the turning spindle; it is no milling move
; 10:1 G84 is refused: tapping ties the feed to the turning spindle, which cannot be shown as plain moves; tap by other means
; 11:1 G51 is refused: it scales the path; post the path as it shall be cut
; 12:1 M61 is refused: it renames the tool in the spindle without a change; use T and M6
; 13:1 M62 is refused: it switches an output or waits for an input; what that does is not known here
; 14:1 G43.2 is refused: it adds a second tool length; name one by G43 H
G5 X1 Y1
G33 K1
G84 X1 Z-1 R1
G51 X2
M61 Q3
M62 P0
G43.2 H1
