; 3:1 D takes a whole number of zero or more: correct it
; 4:1 D takes a whole number of zero or more: correct it
D-1
D=1.5
