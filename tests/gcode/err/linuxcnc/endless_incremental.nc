; 4:1 10000 lines were read again and the program has not ended: a loop without end?
G91 G0
o1 while [1]
X1
o1 endwhile
