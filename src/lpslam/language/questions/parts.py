"""Parts of a question, such as the stops of a plan: a few words in the language of the whole."""

from lpslam.language.questions.question import NO_NAMES, read_question
from lpslam.language.questions.wanted import Wish
from lpslam.language.tables.knowledge import Knowledge
from lpslam.language.tables.lexicon import Meaning
from lpslam.language.tables.words import Phrases


def read_part(text: str, language: str | None, knowledge: Knowledge, names: Phrases[Meaning] = NO_NAMES) -> Wish:
    """Read a part of a question in the language of the whole; in any where it says nothing in that."""
    wish = read_question(text, knowledge, names, language=language)
    says = wish.wanted or wish.refused or wish.wanted_names or wish.refused_names
    return wish if says or language is None else read_question(text, knowledge, names)
