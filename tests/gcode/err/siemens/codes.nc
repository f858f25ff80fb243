; 13:1 G41 is not supported: it moves the path sideways by the tool's radius; post the centre's path with G40
; 14:1 G42 is not supported: it moves the path sideways by the tool's radius; post the centre's path with G40
; 15:1 G74 is not supported: where the reference or fixed point lies is not known; write SUPA with the place
; 16:1 G75 is not supported: where the reference or fixed point lies is not known; write SUPA with the place
; 17:1 G110 is not supported: post the points as X Y Z
; 18:1 G58 is not supported: write TRANS or ATRANS
; 19:1 G33 is not supported: post the motions as G0, G1, G2 and G3
; 20:1 G96 is not supported: write the speed with S and the feed with G94 or G95
; 21:1 G600 is not a command of this controller: remove it, or post the program for this dialect
; 22:1 G25 is not supported: limits are the machine's; remove it
; 23:1 G99 is not a command of this controller: remove it, or post the program for this dialect
; 24:1 G291 is not supported: ISO programs are another dialect; read this one as that
G41 X1
G42
G74 X1=0
G75 FP=1 Z1=0
G110 X0
G58 X1
G33 Z1 K1
G96 S100
G600
G25 X0
G99
G291
