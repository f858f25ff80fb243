; 5:4 parentheses are no comment on this control: write ; in front of a comment, or remove it
; 7:1 G4 needs a P (milliseconds) or S (seconds) word: add it
; 8:1 the dwell has two times: keep one of them
; 9:7 found '/' where a word (a letter and a number) should begin: a slash that skips the line stands at its very front; move or remove it
G0 (up) Z5
G0 Z5 ; (up)
G4
G4 P1 S1
G0 Z5 /2
