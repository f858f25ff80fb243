; 7:8 RL is not supported: it moves the path sideways by the tool's radius; post the centre's path with R0
; 8:8 RR is not supported: it moves the path sideways by the tool's radius; post the centre's path with R0
; 9:8 R+ and R- is not supported: it moves the path sideways by the tool's radius; post the centre's path with R0
; 10:1 APPR is not supported: it moves the path sideways by the tool's radius; post the centre's path with R0
; 11:1 DEP is not supported: it moves the path sideways by the tool's radius; post the centre's path with R0
BEGIN PGM P MM
L X+10 RL F100
L X+10 RR F100
L X+10 R+ F100
APPR LT X+1 Y+1
DEP LCT X+1
END PGM P MM
