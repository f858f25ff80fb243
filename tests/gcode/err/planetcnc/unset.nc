o1 call
G0 X#5
