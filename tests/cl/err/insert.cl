$$ 2:1 INSERT is refused: it puts text of one controller into the program, which no other can read: say it in APT words, or remove it and put it into the post's header
INSERT M98 P1000
