$$ 2:8 COOLNT is refused: only FLOOD and MIST can be posted: choose one of them, or OFF
COOLNT/THRU
