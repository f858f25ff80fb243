; 8:1 ROT is not supported: it turns, scales or mirrors the path; post the path as it shall be
; 9:1 SCALE is not supported: it turns, scales or mirrors the path; post the path as it shall be
; 10:1 MIRROR is not supported: it turns, scales or mirrors the path; post the path as it shall be
; 11:1 AROT needs an axis: add it
; 12:7 "A5" is not understood here: correct it, or post the program again
; 13:10 X stands twice in this block: keep one
; 14:4 TRANS must stand in a block of its own: put the rest on another line
ROT RPL=45
SCALE X2
MIRROR X0
AROT
TRANS A5
TRANS X1 X2
G0 TRANS X1
