; 7:1 G28.1 is refused: here it homes the machine (elsewhere it stores a position); home before the program, not in it
; 8:1 G52 is refused: how it adds to G92 is not documented here; use G54 to G59
; 9:1 M31 is refused: it is a macro that only this machine knows; write out what it does
; 10:1 G85 is not a command of this controller: remove it, or post the program for this dialect
; 11:1 tool number 97 is above 96: use a smaller one
; 12:1 G92.2 is not a command of this controller: remove it, or post the program for this dialect
G28.1
G52 X1
M31
G85 X1 Z-1 R1 F100
T97
G92.2
