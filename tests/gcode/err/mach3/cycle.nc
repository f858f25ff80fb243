; 5:1 this move has no feed rate: put an F word at or before the first cutting move (in G93: on every line)
; 7:15 nothing in this line uses K: remove it, or add the command it belongs to
; 8:1 G84 is refused: tapping ties the feed to the turning spindle, which cannot be shown as plain moves; tap by other means
G0 Z5
G81 X1 Z-1 R1
F100
G81 X1 Z-1 R1 K2
G84 Z-1 R1
