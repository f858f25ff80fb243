; 5:3 A is not supported: this machine has no rotary axes; post the program for three axes
; 6:3 IB is not supported: this machine has no rotary axes; post the program for three axes
; 7:3 W is not supported: this machine has X, Y and Z only; post the program for three axes
BEGIN PGM P MM
L A+10 FMAX
L IB+10 FMAX
L W+10 FMAX
END PGM P MM
