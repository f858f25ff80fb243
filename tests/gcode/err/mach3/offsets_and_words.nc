; 7:5 L is refused: G10 L20 is not there on this control; use L2
; 8:8 P must be a whole number from 1 to 254 here
; 9:5 P must be a whole number from 1 to 254 here
; 10:1 tool number 256 is above 255: use a smaller one
; 11:5 nothing in this line uses P: remove it, or add the command it belongs to
; 12:7 A is not a word of this controller (three axes, X Y Z): remove it
G10 L20 P1 X0
G10 L2 P255 X0
G59 P255
T256
G64 P0.1
G0 X1 A5
