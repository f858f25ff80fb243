; 7:1 G92 is refused: the work zero is set in Carbide Motion, not by the program
; 8:1 G10 is refused: the work zero is set in Carbide Motion, not by the program
; 9:1 G43 is not a command of this controller: remove it, or post the program for this dialect
; 10:1 G28 is refused: where it goes is not documented here; use G53 G0 Z
; 11:1 G81 is refused: drilling cycles are not built in here; write the moves out
; 12:1 G41 is refused: cutter compensation moves the path by a radius that stands in the control's table; post the path of the tool centre and use G40
G92 X0
G10 L2 P1 X0
G43 H1
G28
G81 X1 Z-1 R1
G41 D1
