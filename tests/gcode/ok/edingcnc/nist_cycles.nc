; EDINGCNC manual: cycles as NIST wrote them down
G21 G90 G17
G64 P0.05
G0 Z5
G99 G82 X1 Y1 Z-1 R1 P0.5 F60
G80
M30
