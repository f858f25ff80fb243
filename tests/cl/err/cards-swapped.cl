PARTNO DECK                                                             00000010
UNITS/MM                                                                00000020
RAPID                                                                   00000030
GOTO/1,2,3                                                              00000020
