G0 X#1
#1=2
X#1
Y#<name>
