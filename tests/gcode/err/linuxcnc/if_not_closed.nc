; 2:1 O1 if is never closed: O1 endif is missing
o1 if [1]
G0 X1
M2
