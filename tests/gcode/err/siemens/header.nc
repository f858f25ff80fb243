; 3:1 "%_N_MAIN_XYZ" is not understood here: correct it, or post the program again
; 4:1 "%O1234" is not understood here: correct it, or post the program again
%_N_MAIN_XYZ
%O1234
