; 3:1 the program calls tools by name and by number: which is which cannot be known, keep to one of them
T2 M6
T="MILL" M6
