; 5:8 G53 works with straight moves only: put G0 or G1 on this line
; 6:13 G53 or SUPA with G91 or IC is not supported: write them absolute, with G90 or AC()
; 7:9 G53 or SUPA with G91 or IC is not supported: write them absolute, with G90 or AC()
; 8:9 G53 works with straight moves only: put G0 or G1 on this line
G53 G2 X10 I5 F100
G91 G0 SUPA Z0
G90 G53 X=IC(5)
G500 G3 X10 I5 F100
