; 11:6 GOTOF needs a label or a block number: add it
; 12:1 GOTOC is not supported: write GOTOF or GOTOB with a label
; 13:1 GOTOF or GOTOB with a label, or the end of the block is expected here: correct the expression
; 14:13 GOTOF needs a label or a block number: add it
; 15:1 CASE is not supported: write IF with GOTOF, or a subprogram
; 16:1 REPEATB is not supported: write IF with GOTOF, or a subprogram
; 17:12 REPEAT with two labels is not supported: write the section as a subprogram
; 18:12 P takes a whole number from 1 to 9999: correct it
; 19:1 ENDLABEL is not supported: write the section as a subprogram
; 21:11 "X5" is not understood here: correct it, or post the program again
GOTOF
GOTOC OUT
IF 1>0 G0 X5
IF 1>0 GOTOF
CASE R1 OF 1 GOTOF OUT
REPEATB OUT P=3
REPEAT OUT ENDS P=3
REPEAT OUT P=0
ENDLABEL:
OUT: G0 X1
GOTOF OUT X5
