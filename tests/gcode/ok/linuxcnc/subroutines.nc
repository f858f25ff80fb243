o<drill> sub
(x, y, depth; #4 was not handed over: 0)
G0 X#1 Y#2
Z#3
Z#4
o<drill> endsub [#1 * 2]
G21 G90
#4=5
o<drill> call [10] [2+1] [-1]
X#<_value>
o<DRILL> call [1] [2] [3]
X#1 Y#<_value_returned>
M2
