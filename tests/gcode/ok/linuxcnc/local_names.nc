o1 sub
o2 if [exists[#<depth>]]
G0 X99
o2 endif
#<depth>=3
G0 Z#<depth>
o1 return
G0 X98
o1 endsub
#<depth>=1
o1 call
X#<depth>
M2
