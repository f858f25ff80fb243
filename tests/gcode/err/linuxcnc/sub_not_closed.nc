; 2:1 O1 sub is never closed: O1 endsub is missing
o1 sub
G0 X1
M2
