partno lower
units/mm
spindl/rpm,500,cclw
	rapid
	goto	/ 1 , 2 ,	3
fedrat/ 100 , mmpm
go to / +1.5E+01, - 2.5e-01, .5
end
fini
