$$ 3:1 the machining coordinate system changes here: post each system's operations as a file of their own
MSYS/0,0,0,1,0,0,0,1,0
MSYS/0,0,5,1,0,0,0,1,0
