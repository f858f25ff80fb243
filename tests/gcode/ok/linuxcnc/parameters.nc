%
G20 G90 G0 X1 Y2
(unset numbers are zero, a setting holds behind its line)
X#3000
#3=15
#3=6 G0 X#3
X#3
#<depth of cut>=0.5
Z-#<DepthOfCut>
#<_g>=[#5420 + #<_y>]
X#<_g>
Y[EXISTS[#<_g>] + EXISTS[#<nothing>]]
Z#<_metric>
G21
X#5420
X##3
M2
%
