PARTNO OLD DECK                                                         00000010
UNITS/INCHES                                                            00000020
SPINDL/900,CLW                                                          00000030
FEDRAT/5.0                                                              00000040
FROM/0.0,0.0,2.0                                                        00000050
START)GOTO/1.5,$                                                        00000060
      2.0,$                                                             00000070
                                                                        00000080
      0.5                                                               00000090
PPRINT TEXT UP TO COLUMN 72                                             00000100
END                                                                     00000110
FINI                                                                    00000120
