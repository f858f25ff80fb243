; 3:1 the program calls tools by name and by number: which is which cannot be known, keep to one of them
T="MILL" M6
T2 M6
