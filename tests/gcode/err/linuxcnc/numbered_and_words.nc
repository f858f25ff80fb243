; 4:1 O1 is not in this file, and programs in other files are not read: append it to this file
; 5:5 O7 is not in this file, and programs in other files are not read: append it to this file
G0 X1
o1 call
M98 P7
M2
o7 sub
M99
o7 endsub
