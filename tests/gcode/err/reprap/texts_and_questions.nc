M291 P"change the tool"
M220 S50
M117 "X5"
{move.axes[0].homed}
