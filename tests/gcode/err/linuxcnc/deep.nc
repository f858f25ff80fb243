; 3:34 brackets inside brackets, more than 32 deep: compute a part of it on a line before
; 4:34 brackets inside brackets, more than 32 deep: compute a part of it on a line before
X[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[1]]]]]]]]]]]]]]]]]]]]]]]]]]]]]]]]]
X########################################1
M2
