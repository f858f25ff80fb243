; 7:7 F takes a feed above zero: correct it
; 8:7 F takes a feed above zero: correct it
; 9:7 FZ is not supported: write the feed in mm/min (in INCH programs 0.1 inch/min) with F
; 10:7 F AUTO needs an F in the TOOL CALL before it: add it
; 11:12 F stands twice in this block: keep one
BEGIN PGM P MM
L X+1 F0
L X+1 F-5
L X+1 FZ0.1
L X+1 F AUTO
L X+1 F100 FMAX
END PGM P MM
