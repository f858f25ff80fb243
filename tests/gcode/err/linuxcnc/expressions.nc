; 14:8 found ']' where a value should stand (a number, # and a variable, [ ], or a function): correct the expression
; 15:2 the bracket is not closed: put ] behind the expression
; 16:3 ATAN takes two values: write ATAN[ ... ]/[ ... ]
; 17:5 found '/' where a value should stand (a number, # and a variable, [ ], or a function): correct the expression
; 18:4 found '-' where a value should stand (a number, # and a variable, [ ], or a function): correct the expression
; 19:3 found '+' where a word (a letter and a number) should begin: remove it
; 20:5 found '+' where a word (a letter and a number) should begin: remove it
; 21:7 found ']' where a value should stand (a number, # and a variable, [ ], or a function): correct the expression
; 22:3 FOO is no function of this controller: use ABS ACOS ASIN ATAN COS EXP FIX FUP LN ROUND SIN SQRT TAN
; 23:4 the result is no number that can be used (too large): check the values
; 24:7 SQRT needs its value in brackets: write SQRT[ ... ]
; 25:12 found '}' where an operator or ] should stand: correct the expression
; 26:4 found ',' where an operator or ] should stand: correct the expression
G0 X[1+]
X[1+2
X[ATAN[1]]
X[1//2]
X[--1]
X1+2
#1=2+3
X[1 EQ]
X[FOO[1]]
X[0**-1]
X[[1]+SQRT 4]
X[1]Y[2]Z[3}
X[1,5]
M2
