G21 G90 G0 X0
o1 sub
G91 Y1
G90
o1 endsub
#5=0
o2 while [#5 lt 2]
o1 call
#5=[#5+1]
o2 endwhile
M30
