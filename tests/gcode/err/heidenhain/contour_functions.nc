; 8:1 RND is not supported: post the rounding as an arc (CR)
; 9:1 CHF is not supported: post the chamfer as a line (L)
; 10:1 CTP is not supported: write CR or CP instead
; 11:1 FL is not supported: free contours are computed by the control; post them as L and CR
; 12:1 SPL is not supported: post the spline as short lines (L)
; 13:1 LN is not supported: it tilts or turns the tool, and this machine has three axes; remove it
BEGIN PGM P MM
RND R5
CHF 2
CTP PR+5 PA+5
FL X+10
SPL X+10
LN X+1 Y+1 Z+1
END PGM P MM
