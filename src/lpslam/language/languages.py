"""The languages of questions and answers; signs are read in more."""

LANGUAGES = ("en", "zh", "ja", "ko", "es", "de", "fr")
LATIN = ("en", "es", "de", "fr")
"""Those that are written in Latin letters, with spaces between words."""
CAPITALS_ARE_NAMES = frozenset({"en", "es", "fr"})
"""Those in which a capital within a sentence is a name's."""
UNSPACED = tuple(each for each in LANGUAGES if each not in LATIN)
"""Those in which titles and particles stand right at a name."""
