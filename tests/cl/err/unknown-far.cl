$$ 2:1 XQZWVK is not known: remove the line if it moves and switches nothing, or write it in words of ISO 4343
XQZWVK/1
