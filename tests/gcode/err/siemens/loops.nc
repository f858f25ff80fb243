; 9:1 WHILE is not supported: loops of this kind are not read; write a label with IF and GOTOB
; 10:1 ENDWHILE is not supported: loops of this kind are not read; write a label with IF and GOTOB
; 11:1 FOR is not supported: loops of this kind are not read; write a label with IF and GOTOB
; 12:1 ENDFOR is not supported: loops of this kind are not read; write a label with IF and GOTOB
; 13:1 LOOP is not supported: loops of this kind are not read; write a label with IF and GOTOB
; 14:1 ENDLOOP is not supported: loops of this kind are not read; write a label with IF and GOTOB
; 15:1 REPEAT with UNTIL is not supported: loops of this kind are not read; write a label with IF and GOTOB
; 16:1 UNTIL is not supported: loops of this kind are not read; write a label with IF and GOTOB
WHILE R1>0
ENDWHILE
FOR R1=1 TO 5
ENDFOR
LOOP
ENDLOOP
REPEAT
UNTIL R1>5
