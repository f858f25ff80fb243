; 3:4 A is not supported: this machine has X, Y and Z only; post the program for three axes
; 4:4 W is not supported: this machine has X, Y and Z only; post the program for three axes
G0 A10
G0 W5
