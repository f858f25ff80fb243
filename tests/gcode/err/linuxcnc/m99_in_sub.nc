; 3:1 M99 closes nothing: M98 is missing, or was jumped over
o7 sub
M99
o7 endsub
o7 call
M2
