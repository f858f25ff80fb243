; 12:3 M92 is not supported: where the additional machine datum lies is not known; write M91, or the place in the part's system
; 13:3 M140 is not supported: where it retracts to is not known; write the height, as in L Z+100 R0 FMAX
; 14:3 M128 is not supported: this reader does not carry it out; remove it
; 15:3 M97 is not supported: it changes the path of radius compensation or the tool; remove it
; 16:3 M109 is not supported: it changes the feed; write the feed with F
; 17:3 M300 is not supported: it is the machine builder's, and what it does is not known; remove it
; 18:6 M3 stands twice in this block: keep one
; 19:4 M takes a whole number: correct it
; 20:18 M takes at most four functions in a block: correct it
; 21:13 M91 with I coordinates is not supported: write them without I, from the machine's datum
BEGIN PGM P MM
L M92 Z+0 FMAX
L M140 MB MAX
L M128
L M97
L M109
L M300
L M3 M3
L M3.5
L M3 M8 M91 M126 M127
L IX+1 FMAX M91
END PGM P MM
