; 4:1 ELSE without an IF before it: remove it, or add the IF
; 5:1 ENDIF without an IF before it: remove it, or add the IF
; 9:1 ENDIF without an IF before it: remove it, or add the IF
ELSE
ENDIF
IF 1>0
ELSE
ENDIF
ENDIF
