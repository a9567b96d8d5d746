"""What first questions would have to build, built before they come: a few milliseconds at a time."""

from collections.abc import Iterator

from lpslam.language.building import steps_of
from lpslam.language.languages import LANGUAGES
from lpslam.language.tables.inflection import known_form
from lpslam.language.tables.knowledge import Knowledge
from lpslam.language.wishes.rules import rules_of

_UNKNOWN_WORD = "xqzzkvwj"
"""A form of no word: all tables of forms are gone through for it."""


def language_steps(knowledge: Knowledge) -> Iterator[None]:
    """Build what belongs to the languages of questions: rules, forms of words, lengths of phrases."""
    for language in LANGUAGES:
        for row in rules_of(language).rows:
            row.prepare()
            yield
        known_form(_UNKNOWN_WORD, language, knowledge)
        yield
        for is_plain in (False, True):
            yield from steps_of(knowledge.tables_of(language, is_plain))
