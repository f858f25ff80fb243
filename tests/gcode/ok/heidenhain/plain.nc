; no block numbers, structure lines
BEGIN PGM PLAIN MM
* - ROUGHING

BLK FORM CYLINDER Z R50 L105
L  X +10 Y+ 5   R0 F MAX
L Z-1 F 100 M3 ; cut
END PGM PLAIN MM
