; 6:1 the drilling cycle needs P (seconds): add it
; 7:1 this cycle stops the spindle and starts it again, but it does not turn: put M3 and S before it
; 8:9 P must be a whole number from 1 to 9 here
; 9:5 G0 and an earlier word of this line belong to the same group (motion): keep one of them
G0 Z5 F100
G82 X1 Z-1 R1
G86 X1 Z-1 R1 P1
G10 L20 P10 X0
G80 G0 X1
