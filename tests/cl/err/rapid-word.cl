$$ 2:7 RAPID does not take MODIFY: it takes FEED and a feed, or nothing
RAPID/MODIFY
