; 8:4 G1 and G0 belong to the same group (motion): keep one of them
; 9:5 G55 and G54 belong to the same group (work offset): keep one of them
; 10:8 G91 and G90 belong to the same group (absolute or incremental): keep one of them
; 11:4 M4 and M3 belong to the same group (spindle): keep one of them
; 12:4 M9 and M8 belong to the same group (coolant): keep one of them
; 13:4 M30 and M0 belong to the same group (stop and end): keep one of them
; 14:1 G takes a whole number of zero or more: correct it
G0 G1 X1
G54 G55
G90 X1 G91
M3 M4
M8 M9
M0 M30
G1.5
