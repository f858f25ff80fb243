; 2:45 the expression is nested too deeply: split it over several variables
R1=((((((((((((((((((((((((((((((((((((((((((((((((((((((((((((1))))))))))))))))))))))))))))))))))))))))))))))))))))))))))))
