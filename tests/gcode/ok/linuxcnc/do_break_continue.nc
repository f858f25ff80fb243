G21 G90 G0
#1=0
o1 do
#1=[#1+1]
o2 if [#1 eq 2]
o1 continue
o2 endif
X#1
o1 while [#1 lt 3]
o3 repeat [3]
o4 while [1]
Y1
o4 break
Y99
o4 endwhile
G91 Z1
G90
o3 endrepeat
o5 repeat [0]
X99
o5 endrepeat
o6 while [0]
X98
o6 endwhile
o7 repeat [5]
o8 if [#1 ge 4]
o7 break
o8 endif
#1=[#1+1]
o7 continue
X97
o7 endrepeat
X#1
M2
