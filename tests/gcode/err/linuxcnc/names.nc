; 12:5 #<depth> has no value here: set it on a line before
; 13:1 the variable's name is not closed: put > behind it
; 14:3 EXISTS takes the name of a variable: write EXISTS[#<name>]
; 15:3 EXISTS takes the name of a variable: write EXISTS[#<name>]
; 16:1 #<_x> cannot be set here (it belongs to the machine): use a variable of the program's own
; 17:1 #5220 cannot be set here (it belongs to the machine): use a variable of the program's own
; 18:1 #<_ini[setup]xpos> cannot be set here (it belongs to the machine): use a variable of the program's own
; 19:2 #<_current_tool> has no value here: set it on a line before
; 20:2 #5400 is known to the machine only (kept from earlier runs, or its own state): set it in the program
; 21:2 #0 is no variable of this controller: use another number
; 22:2 the number of a variable must be whole and not negative, here it is -1
G0 X#<depth>
#<depth=5
X[EXISTS[#1]]
X[EXISTS[5]]
#<_x>=1
#5220=2
#<_ini[setup]xpos>=1
X#<_current_tool>
X#5400
X#0
X#[0-1]
M2
