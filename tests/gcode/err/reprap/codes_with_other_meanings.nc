; 9:1 G28 is refused: here it homes the machine by its switches, without an intermediate point (elsewhere it goes to a stored place); home before the program, not in it
; 10:1 G29 is refused: here it measures the bed; do that before the program
; 11:1 M1 is refused: here it ends the job and sleeps (elsewhere an optional stop); use M226 or M0
; 12:1 M30 is refused: here it deletes a file (elsewhere it ends the program); remove it
; 13:1 M6 is refused: a T word changes the tool at once here; write T
; 14:1 M98 is refused: macro files lie on the machine and cannot be read here; write out what they do
; 15:1 G30 is refused: here it probes the bed at one point (elsewhere it goes to a stored place); remove it
; 16:1 G68 is refused: it turns the coordinate system; post the path as it shall be cut
G28 X0
G29
M1
M30
M6
M98
G30
G68 X0 Y0 R45
