; 4:4 X has no number: write sign, digits and at most one dot after it (no exponents, variables or expressions)
; 5:3 found '５' where a word (a letter and a number) should begin: remove it
; 6:1 found 'Х' where a word (a letter and a number) should begin: remove it
G0 X١
X1５
Х 1
M2
