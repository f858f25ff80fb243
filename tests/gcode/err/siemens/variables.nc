; 12:10 DEF needs a name that begins with two letters, 31 characters at most: add it
; 13:1 DEF of this type is not supported: REAL, INT and BOOL are read
; 14:1 DEF needs a type (REAL, INT or BOOL): add it
; 15:10 an array is not supported: define single variables
; 16:9 DEF needs a name that begins with two letters, 31 characters at most: add it
; 17:15 COUNT works on numbers: put comparisons in parentheses, as in (R1>0) AND (R2>0)
; 18:15 FLAG works on conditions: put comparisons in parentheses, as in (R1>0) AND (R2>0)
; 19:1 DEPTH is not a known variable, function or address: define it with DEF, or correct it
; 20:6 DEPTH is not a known variable, function or address: define it with DEF, or correct it
; 21:1 $ is not supported: system variables are the control's, and not known here
; 22:4 $ is not supported: system variables are the control's, and not known here
DEF REAL A
DEF STRING[10] NAME
DEF FOO BAR
DEF REAL LIST[5]
DEF REAL
DEF INT COUNT=1>0
DEF BOOL FLAG=5
DEPTH=5
G0 X=DEPTH
$TC_DP1[1,1]=5
R1=$P_TOOLNO
