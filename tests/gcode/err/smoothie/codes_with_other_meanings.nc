; 8:1 G28 is refused: here it homes the machine by its switches, without an intermediate point (elsewhere it goes to a stored place); home before the program, not in it
; 9:1 G28.2 is refused: here it homes the machine by its switches, without an intermediate point (elsewhere it goes to a stored place); home before the program, not in it
; 10:1 G30 is refused: here it probes the bed at one point (elsewhere it goes to a stored place); remove it
; 11:1 G32 is refused: here it measures the bed; do that before the program
; 12:1 M30 is refused: here it deletes a file (elsewhere it ends the program); remove it
; 13:1 M106 is refused: here it is a fan (some wire a spindle to it); use M3 and M5
; 14:1 M6 is refused: tools are changed by an option of the build here; pause by M0
G28
G28.2
G30
G32
M30 Q1
M106
M6
