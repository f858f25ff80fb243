$$ 6:20 brackets stand more than 8 deep here: this is no cutter-location data
UNITS/MM
FEDRAT/100,MMPM
RAPID
GOTO/5,0,0
TLON,GOFWD/(((((((((CIRCLE/1)))))))))
