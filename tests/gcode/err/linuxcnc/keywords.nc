; 11:1 wend is no keyword of this controller: sub, endsub, call, return, if, elseif, else, endif, while, endwhile, do, repeat, endrepeat, break, continue
; 12:6 if needs a value in brackets: [ ... ]: add it
; 13:10 while needs a value in brackets: [ ... ]: add it
; 14:10 the number of repetitions must be a whole number from 0 to 1000000000, here it is 1.5
; 15:10 the number of repetitions must be a whole number from 0 to 1000000000, here it is -1
; 16:1 O1 endrepeat closes nothing: O1 repeat is missing, or was jumped over
; 17:1 sub is no keyword of this controller: behind a computed number only call can stand
; 18:1 O needs a number, or a name in < >: add it
; 19:9 call stands alone on its line: move the rest of it to another line
; 20:11 if stands alone on its line: move the rest of it to another line
o1 wend
o1 if
o1 while 1
o1 repeat [1.5]
o1 repeat [-1]
o1 endrepeat
o[1+1] sub
o call
o1 call 5
o1 if [1] G0
M2
