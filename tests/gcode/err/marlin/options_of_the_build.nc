; 6:1 G20 is refused: inches are an option of the build, and a firmware without it takes them for millimetres; post in millimetres
; 7:1 G18 is refused: planes are an option of the build, and a firmware without it cuts the arc in X and Y; use lines
; 8:1 G55 is refused: coordinate systems are an option of the build; use G92
; 9:1 G53 is refused: coordinate systems are an option of the build; post in work coordinates
; 10:1 G93 is not a command of this controller: remove it, or post the program for this dialect
G20
G18
G55
G53 G0 X0
G93
