; 6:7 E is refused: it moves an extruder, and a mill has none; remove it
; 7:1 T is refused: here it switches to another extruder at once; pause by M0 for a tool change
; 8:1 M104 is refused: it heats, and a mill has nothing to heat; remove it
; 9:1 M84 is refused: it lets go of the motors, and the position is lost; remove it
; 10:1 M6 is refused: tools are changed by the machine's own script here; pause by M0
G1 X5 E2 F600
T1
M104 S200
M84
M6
