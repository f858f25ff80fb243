; 4:1 PLANE is not supported: it tilts or turns the tool, and this machine has three axes; remove it
; 5:1 FUNCTION is not supported: it tilts or turns the tool, and this machine has three axes; remove it
BEGIN PGM P MM
PLANE SPATIAL SPA+10 SPB+0 SPC+0 STAY
FUNCTION TCPM F TCP AXIS POS PATHCTRL AXIS
END PGM P MM
