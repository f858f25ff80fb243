; 3:1 O1 while is never closed: O1 endwhile is missing
; 5:1 O2 endwhile closes nothing: O2 while is missing, or was jumped over
o1 while [1]
G0 X1
o2 endwhile
M2
