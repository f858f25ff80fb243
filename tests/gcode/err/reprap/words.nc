; 5:7 E is refused: it moves an extruder, and a mill has none; remove it
; 7:1 this move has no feed rate: put an F word at or before the first cutting move (in G93: on every line)
; 8:1 tool number 50 is above 49: use a smaller one
; 9:1 G59.4 is not a command of this controller, and without its fraction it would mean something else: post the program for this dialect
G1 X5 E1 F100
G0 X1 F3000
G1 X2
T50
G59.4
