; 3:1 calls inside calls, 10 deep, are all that this controller does: does a subprogram call itself?
o1 sub
o1 call
o1 endsub
o1 call
M2
