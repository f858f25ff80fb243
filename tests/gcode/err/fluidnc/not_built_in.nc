; 7:1 G81 is refused: drilling cycles are not built in here; write the moves out
; 8:1 G98 is refused: drilling cycles are not built in here; write the moves out
; 9:1 G43 is not a command of this controller: remove it, or post the program for this dialect
; 10:1 G59.1 is not a command of this controller, and without its fraction it would mean something else: post the program for this dialect
; 11:1 M61 is refused: it renames the tool in the spindle without a change; use T and M6
; 12:1 M19 is not a command of this controller: remove it, or post the program for this dialect
G81 X1 Z-1 R1 F100
G98
G43 H1
G59.1
M61 Q1
M19
