G0 X1. ; move on
G0 X1. ;
(a ; b) G0 X2.
G0 (open X1.
G0 X1. (one) ; (two)
