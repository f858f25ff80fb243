; 2:12 found 'Â°' where a word (a letter and a number) should begin: remove it
(äö) G0 X1 °
