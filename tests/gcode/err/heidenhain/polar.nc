; 11:3 LP needs PA without I: the tool stands on the pole: add it
; 12:4 "X" is not understood here: correct it, or post the program again
; 13:3 the arc starts 0.0000 mm from CC but ends 0.0000 mm from it: correct CC or the end point
; 15:3 CP needs an angle (PA or IPA): add it
; 16:3 IPA takes the sign of DR, and degrees up to 5400 that are not zero: correct it
; 17:3 IPA takes the sign of DR, and degrees up to 5400 that are not zero: correct it
; 18:3 CP needs a direction (DR+ counter-clockwise, DR- clockwise): add it
; 19:3 "PR" is not understood here: correct it, or post the program again
BEGIN PGM P MM
CC X+0 Y+0
LP IPA+90 F100
LP X+5 PA+0 F100
CP IPA+90 DR+ F100
L X+10 FMAX
CP DR+ F100
CP IPA-90 DR+ F100
CP IPA+5401 DR+ F100
CP IPA+90 F100
CP PA+90 PR+5 DR+ F100
END PGM P MM
