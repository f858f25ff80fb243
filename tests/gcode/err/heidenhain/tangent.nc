; 6:3 CT needs a contour block in X and Y right before it, and an end point off its tangent: write L or CR instead
; 8:3 CT needs a contour block in X and Y right before it, and an end point off its tangent: write L or CR instead
; 10:3 CT needs a contour block in X and Y right before it, and an end point off its tangent: write L or CR instead
; 11:3 CT needs an end point in X and Y: add it
BEGIN PGM P MM
CT X+10 Y+10 F100
L X+10 FMAX
CT X+20 Y+0 F100
L Z+5 FMAX
CT X+20 Y+10 F100
CT Z+1 F100
END PGM P MM
