; 17:4 SQRT gives no number here: correct the values
; 18:4 FOO is not a known variable, function or address: define it with DEF, or correct it
; 19:4 SIN is not a known variable, function or address: define it with DEF, or correct it
; 20:8 a closing parenthesis is expected here: correct the expression
; 21:11 a comma and the function's next argument is expected here: correct the expression
; 22:6 MOD gives no number here: correct the values
; 23:8 DIV takes whole numbers: correct it
; 24:4 R works on numbers: put comparisons in parentheses, as in (R1>0) AND (R2>0)
; 26:9 AND works on conditions: put comparisons in parentheses, as in (R1>0) AND (R2>0)
; 27:4 IF works on conditions: put comparisons in parentheses, as in (R1>0) AND (R2>0)
; 28:8 a pair of parentheses around each comparison is expected here: correct the expression
; 29:4 EX gives no number here: correct the values
; 30:4 a whole exponent behind EX is expected here: correct the expression
; 31:4 a number, an R parameter or a variable is expected here: correct the expression
; 32:5 << is not supported: texts are not joined; write one text
; 33:9 BOUND takes a least value, a greatest one, and the value: correct it
R1=SQRT(-1)
R1=FOO(5)
R1=SIN 30
R1=(5+3
R1=ATAN2(1)
R1=5 MOD 0
R1=5.5 DIV 2
R1=1>0
R2=1 R3=2
IF R2>0 AND R3>0 GOTOF OUT
IF R2 GOTOF OUT
IF 1<R2<3 GOTOF OUT
R1=1EX999
R1=1EXX
R1="A"<<"B"
R1=5<<2
OUT: R1=BOUND(5,1,2)
