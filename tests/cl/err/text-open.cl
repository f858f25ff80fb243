$$ 2:10 the statement ends where the closing apostrophe should stand
LOADTL/1,'D 6
