; 10:1 G28 is refused: here it homes the machine by its switches, without an intermediate point (elsewhere it goes to a stored place); home before the program, not in it
; 11:1 G28 is refused: here it homes the machine by its switches, without an intermediate point (elsewhere it goes to a stored place); home before the program, not in it
; 12:1 G29 is refused: here it measures the bed; do that before the program
; 13:1 G30 is refused: here it probes the bed at one point (elsewhere it goes to a stored place); remove it
; 14:1 M30 is refused: here it deletes a file (elsewhere it ends the program); remove it
; 15:1 M2 is refused: Marlin has no end of program; switch off by M5 and M9 and let the file end
; 16:1 G10 is refused: here it retracts filament (elsewhere it sets offsets); remove it
; 17:1 G61 is refused: here it returns to a stored position (elsewhere it means exact stop); remove it
; 18:1 M106 is refused: here it is a fan (some wire a spindle to it); use M3 and M5
G28
G28 X0
G29
G30
M30
M2
G10
G61
M106 S255
