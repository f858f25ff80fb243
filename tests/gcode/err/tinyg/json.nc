{"gc":"G0 X1"}
$xvm=1000
?
!
G0 X1
