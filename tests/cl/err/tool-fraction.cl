$$ 2:8 LOADTL: 1.5 is no tool number: write a whole number
LOADTL/1.5
