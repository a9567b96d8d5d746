"""What words mean and how they are compared: the lexicon, the gazetteer, folding."""
