$$ 2:8 COOLNT: 0 is no kind of coolant: write FLOOD, MIST or OFF
COOLNT/1
