$H
!
~
G0 X1
