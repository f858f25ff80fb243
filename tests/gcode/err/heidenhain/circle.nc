; 14:2 the arc starts 10.0000 mm from CC but ends 11.0000 mm from it: correct CC or the end point
; 15:2 C needs a direction (DR+ counter-clockwise, DR- clockwise): add it
; 16:2 C needs an end point in X and Y: add it
; 17:12 DR needs a sign (DR+ or DR-): add it
; 18:16 FMAX in an arc is not supported: write a feed, or a straight block
; 19:3 this move has no feed rate: put an F word at or before the first cutting move (in G93: on every line)
; 20:21 M91 is not supported: it goes with straight blocks (L) only
; 21:3 "PR or PA" is not understood here: correct it, or post the program again
; 22:3 "DR" is not understood here: correct it, or post the program again
; 24:2 the arc starts 0.0000 mm from CC but ends 0.0000 mm from it: correct CC or the end point
BEGIN PGM P MM
L X+10 FMAX
CC X+0 Y+0
C X+0 Y+11 DR+ F100
C X+0 Y+10 F100
C DR+ F100
C X+0 Y+10 DR F100
C X+0 Y+10 DR+ FMAX
C X+0 Y+10 DR+
C X+0 Y+10 DR+ F100 M91
C X+0 Y+10 PA+5 DR+ F100
L X+5 DR+ F100
CC X+10 Y+0
C X+10 Y+0 DR+ F100
END PGM P MM
