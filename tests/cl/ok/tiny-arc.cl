UNITS/MM
FEDRAT/100,MMPM
RAPID
GOTO/10.,0.,0.
$$ a fillet of a few hundredths, and one that turns by nothing
MOVARC/10.02,0.,0.,0.,0.,-1.,.02,ANGLE,90.
GOTO/10.02,.02,0.
MOVARC/0.,0.02,0.,0.,0.,1.,10.02,ANGLE,0.
GOTO/10.02,.02,0.
END
FINI
