$$ 2:8 MULTAX does not take YES: it takes ON or OFF
MULTAX/YES
