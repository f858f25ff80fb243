; 6:7 H is refused: tool lengths are measured by Carbide Motion at M6; remove it
; 7:1 this move has no feed rate: put an F word at or before the first cutting move (in G93: on every line)
; 8:1 the arc has no centre: give I or J, or R
; 9:1 M62 is not a command of this controller: remove it, or post the program for this dialect
; 10:5 G64 is not a command of this controller: remove it, or post the program for this dialect
G0 X1 H1
G1 X5
G2 X5 Y5 F100
M62 P1
G61 G64
