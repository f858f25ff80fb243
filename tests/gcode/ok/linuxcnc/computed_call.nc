o3 sub
G0 X[#1]
o3 endsub
#50=1
o[#50+2] call [7]
(lower case, blanks, a line number and block delete)
/ n10 o3 call [ 8 ]
g0 x 1 . 5
M2
X99
