G21 G90 G0
#31=0
o1 while [#31 le 3]
o2 if [#31 eq 0]
X1
o2 elseif [#31 eq 1]
X2
o2 elseif [#31 eq 2]
X3
o3 if [1]
Y1
o3 else
Y99
o3 endif
o2 else
X4
o2 endif
#31=[#31+1]
o1 endwhile
M2
