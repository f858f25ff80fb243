$$ 2:7 the statement ends where a value behind the slash should stand
RAPID/
