; 2:1 O<probe> is not in this file, and programs in other files are not read: append it to this file
o<probe> call [1]
M2
