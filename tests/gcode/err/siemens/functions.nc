; 6:1 M19 is not supported: the spindle is only switched here; remove it
; 7:1 M60 is not supported: it is the machine builder's, and what it does is not known; remove it
; 8:1 M2 is not supported: this machine has one spindle; write S and M3
; 9:1 S2 is not supported: this machine has one spindle; write S and M3
; 10:1 M takes a whole number of zero or more: correct it
M19
M60
M2=3
S2=100
M-1
