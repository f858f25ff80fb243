; 9:1 O1 endif closes nothing: O1 if is missing, or was jumped over
; 10:1 O2 else closes nothing: O2 if is missing, or was jumped over
; 11:1 O3 elseif closes nothing: O3 if is missing, or was jumped over
; 12:1 O4 endrepeat closes nothing: O4 repeat is missing, or was jumped over
; 13:1 O5 break closes nothing: O5 while, do or repeat is missing, or was jumped over
; 14:1 O6 continue closes nothing: O6 while, do or repeat is missing, or was jumped over
; 15:1 O7 endsub closes nothing: O7 sub is missing, or was jumped over
; 16:1 O8 return closes nothing: O8 sub is missing, or was jumped over
o1 endif
o2 else
o3 elseif [1]
o4 endrepeat
o5 break
o6 continue
o7 endsub
o8 return
M2
