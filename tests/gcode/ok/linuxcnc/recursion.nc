o10 sub
o11 if [#1 gt 0]
G0 X#1
o10 call [#1 - 1]
Y#1
o11 endif
o10 endsub
G21 G90
o10 call [3]
M2
