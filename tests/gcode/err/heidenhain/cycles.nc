; 11:10 cycle 203 is not supported: this reader carries out cycles 7, 9, 32, 200, 201 and 247; post the motions themselves
; 12:10 cycle 10 is not supported: this reader carries out cycles 7, 9, 32, 200, 201 and 247; post the motions themselves
; 13:10 cycle 19 is not supported: this reader carries out cycles 7, 9, 32, 200, 201 and 247; post the motions themselves
; 14:9 CYCL DEF needs a cycle's number: add it
; 15:6 CYCL needs DEF or CALL: add it
; 16:1 no cycle is defined that could be called: put a CYCL DEF before it
; 17:12 no cycle is defined that could be called: put a CYCL DEF before it
; 18:12 no cycle is defined that could be called: put a CYCL DEF before it
; 19:1 CYCL CALL POS or PAT is not supported: write the position as L and call with M99
BEGIN PGM P MM
CYCL DEF 203 UNIVERSAL DRILLING ~
CYCL DEF 10.0 ROTATION
CYCL DEF 19.0 WORKING PLANE
CYCL DEF
CYCL RUN
CYCL CALL
L X+1 FMAX M99
L X+1 FMAX M89
CYCL CALL POS X+1
END PGM P MM
