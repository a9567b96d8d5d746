"""The languages of questions and answers; signs are read in more."""

LANGUAGES = ("en", "zh", "ja", "ko", "es", "de", "fr")
LATIN = ("en", "es", "de", "fr")
"""Those that are written in Latin letters, with spaces between words."""
