; 5:1 F takes a feed of zero or more: correct it
; 6:1 S takes a speed of zero or more: correct it
; 7:6 ADIS takes a length of zero or more: correct it
; 8:10 / gives no number here: correct the values
F-5
S-5
G641 ADIS=-1
G1 X1 F=1/0
