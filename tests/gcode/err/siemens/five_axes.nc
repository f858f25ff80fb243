; 5:1 TRAORI is not supported: it turns the tool or the part, and this machine has three axes; remove it
; 6:1 CYCLE800 is not supported: it turns the tool or the part, and this machine has three axes; remove it
; 7:1 ORIWKS is not supported: it turns the tool or the part, and this machine has three axes; remove it
; 8:4 RTLIOF is not supported: each axis would rapid at its own pace, off the straight line; write RTLION
TRAORI
CYCLE800(1,"TC",0,57,0,0,0)
ORIWKS
G0 RTLIOF X1
