; 7:1 M25 is refused: here it moves Z to its home, the first return point (elsewhere it does something else or nothing); use G53 or G28
; 8:1 M26 is refused: it sets an axis to its home; do that at the control
; 9:1 G10 is refused: here it writes the control's own tables and parameters; set them at the control
; 10:1 G118 is refused: it sets a turned plane; post the path in G18
; 11:1 M94 is refused: it switches an output or waits for an input; what that does is not known here
; 12:1 G84 is refused: tapping ties the feed to the turning spindle, which cannot be shown as plain moves; tap by other means
M25
M26
G10 P1 R5
G118
M94 /1
G84 Z-5 R2
