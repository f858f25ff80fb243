; 6:4 the tool length is off (D0), so Z is not the tool's tip: program D1, or retract with SUPA or G53
; 7:4 the tool length is off (D0), so Z is not the tool's tip: program D1, or retract with SUPA or G53
; 8:1 the tool length is off (D0), so Z is not the tool's tip: program D1, or retract with SUPA or G53
T1 M6
D0
G0 Z5
X1 Z5
CYCLE81(5,0,1,-5)
