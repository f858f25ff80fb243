; 7:3 no circle of radius 10.0000 mm joins points 30.0000 mm apart: correct R or the end point (full circles are written with CC and C)
; 8:3 no circle of radius 10.0000 mm joins points 0.0000 mm apart: correct R or the end point (full circles are written with CC and C)
; 9:3 CR needs a radius (R+ up to half a circle, R- beyond): add it
; 10:3 CR needs a direction (DR+ counter-clockwise, DR- clockwise): add it
; 11:3 CR needs a radius (R+ up to half a circle, R- beyond): add it
BEGIN PGM P MM
CR X+30 Y+0 R+10 DR+ F100
CR X+0 Y+0 R+10 DR+ F100
CR X+10 Y+0 DR+ F100
CR X+10 Y+0 R+10 F100
CR X+10 Y+0 R0 DR+ F100
END PGM P MM
