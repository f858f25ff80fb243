; 2:1 O1 is defined on line 4, below its call: this controller wants subroutines above it
o1 call
M2
o1 sub
o1 endsub
