; 7:1 G28.1 is refused: here it homes the machine (elsewhere it stores a position); home before the program, not in it
; 8:1 G70 is refused: here it may mean inches; write G20
; 9:1 G12 is refused: the circular pocket moves by the control's own rules; write the moves out
; 10:1 G68 is refused: it turns the coordinate system; post the path as it shall be cut
; 11:1 G52 is refused: Mach3 keeps it together with G92 in ways that differ by version; use G54 to G59
; 12:1 G31 is refused: the skip move ends where a signal comes, which cannot be foreseen
G28.1 X0 Y0
G70
G12 I5
G68 A0 B0 R45
G52 X5
G31 Z-5 F50
