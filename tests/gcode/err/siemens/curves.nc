; 8:1 CIP is not supported: write the arc as G2 or G3 with I J K or CR
; 9:4 I1 is not supported: write the arc as G2 or G3 with I J K or CR
; 10:1 CT is not supported: write the arc as G2 or G3 with I J K or CR
; 11:1 BSPLINE is not supported: post the curve as G1, G2 and G3
; 12:1 RND is not supported: post the corner as G1, G2 or G3
; 13:8 CHF is not supported: post the corner as G1, G2 or G3
; 14:1 AP is not supported: post the point as X Y Z
CIP X10 I1=5 J1=5
G0 I1=5
CT X10
BSPLINE X10
RND=5
G1 X10 CHF=2 F100
AP=30 RP=5
