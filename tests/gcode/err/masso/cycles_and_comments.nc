; 6:7 the comment is not closed: put ) before the end of the line
; 7:1 this move has no feed rate: put an F word at or before the first cutting move (in G93: on every line)
; 8:15 nothing in this line uses L: remove it, or add the command it belongs to
; 9:1 G85 is not a command of this controller: remove it, or post the program for this dialect
; 10:1 G92 needs at least one of X Y Z: add it
G0 Z5 (open
G81 X1 Z-1 R1
G81 X1 Z-1 R1 L2 F100
G85 X1 Z-1 R1
G92 (nothing)
