; 5:1 M6 needs a T before it, in this block or an earlier one: add it
; 6:1 T takes a whole number of zero or more: correct it
; 7:3 T needs a closing quotation mark: add it
; 8:1 T takes names of 1 to 31 characters: correct it
M6
T-1
T="MILL
T=""
