; 16:1 CYCLE81 needs its arguments in parentheses: add it
; 17:1 CYCLE81 needs RTP and RFP, its first two arguments: add it
; 18:1 CYCLE81 needs a depth (DP or DPR): add it
; 19:1 DP together with DPR is not supported: give one of them
; 20:1 CYCLE81 takes RTP not below RFP, and a depth below RFP (alarm 61101): correct it
; 21:1 CYCLE81 takes RTP not below RFP, and a depth below RFP (alarm 61101): correct it
; 22:1 SDIS takes a distance without sign: correct it
; 23:1 DTB in revolutions is not supported: give seconds, above zero
; 24:22 CYCLE81 with more arguments is not supported: this reader knows RTP, RFP, SDIS, DP, DPR and DTB, and what stands behind them changes what these mean; post the motions themselves
; 25:1 CYCLE83 is not supported: this reader carries out CYCLE81 and CYCLE82; post the motions themselves
; 26:1 MCALL CYCLE85 is not supported: this reader carries out CYCLE81 and CYCLE82; post the motions themselves
; 28:1 drilling in G18 or G19 is not supported: write G17 before the cycle
; 30:1 a cycle under G500 is not supported: write G54 before the cycle
; 31:12 a comma or a closing parenthesis is expected here: correct the expression
F100
CYCLE81
CYCLE81(50)
CYCLE81(50,0,2)
CYCLE81(50,0,2,-5,5)
CYCLE81(50,0,2,5)
CYCLE81(-1,0,2,-5)
CYCLE81(50,0,-2,-5)
CYCLE82(50,0,2,-5,,-3)
CYCLE81(50,0,2,-5,,0,10,1,12)
CYCLE83(50,0,2,-5)
MCALL CYCLE85(1,2)
G18
CYCLE81(50,0,2,-5)
G17 G500
CYCLE81(50,0,2,-5)
CYCLE81(50 0)
