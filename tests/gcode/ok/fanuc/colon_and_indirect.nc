%
:0007
G21 G90 G0
#101=4.
#[100+2]=5.
#103=101
X##103 Y#102
#104=#0
IF [#104 EQ #0] GOTO 8
X99.
N8 Z[#[#103]+1]
M30
%
this is behind the tape and nobody reads it
