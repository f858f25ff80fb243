; 6:7 P must be a whole number from 1 to 248 here
; 7:1 P must be a whole number from 1 to 248 here
; 8:1 G28.1 is refused: here it homes the machine (elsewhere it stores a position); home before the program, not in it
; 9:1 G16 is refused: polar coordinates turn X and Y into radius and angle; post plain coordinates
; 10:9 P must be a whole number from 1 to 248 here
G54.1 P249
G54.1
G28.1
G16
G10 L20 P249 X0
