"""Plans that are told as a chain: clauses that are joined one after the other, each for a place of its own.

“표 사고, 짐 맡기고, 커피 마시자”, 切符を買って、荷物を預けて, “sacar dinero, comprar un libro y tomar un café”: each
language has its `joints`, after which the next clause begins. Whether the pieces are stops is for the reader to say.
"""

from collections.abc import Sequence

from lpslam.language.tables.words import is_unspaced
from lpslam.language.wishes.rules import Rules, rules_of

_ENDS = " .。!！?？,，、;；¿¡"
_MOST_LETTERS = 60  # of a piece: longer ones tell of something
_BARE_WORDS = 2  # of a stop of a plan that is a name alone
_BRIEF_WORDS, _BRIEF_LETTERS = 5, 16  # of a piece of a mere list, in scripts with and without spaces


def chained(text: str, languages: Sequence[str]) -> list[str]:
    """Return the pieces of a text between the joints of the first language that has any; one without."""
    for language in languages[:1]:
        rules = rules_of(language)
        pieces = _merged([piece.strip(_ENDS) for piece in rules.joints.split(text)], rules)
        if len(pieces) > 1 and all(len(piece) <= _MOST_LETTERS for piece in pieces):
            return pieces
    return [text]


def is_brief(piece: str) -> bool:
    """Whether a piece is short enough to be an item of a mere list."""
    return len(piece.split()) <= _BRIEF_WORDS and (len(piece) <= _BRIEF_LETTERS or not is_unspaced(piece))


def is_bare(piece: str, rules: Rules) -> bool:
    """Whether a part of a plan is hardly more than a name: “then to lush”."""
    return 0 < len(rules.filler.sub(" ", piece).strip(_ENDS + "'’").split()) <= _BARE_WORDS


def says_an_order(text: str, languages: Sequence[str]) -> bool:
    """Whether a text has a word that puts things in order: first, 先, 먼저."""
    return any(rules_of(language).ordering.search(text) is not None for language in languages[:1])


def _merged(pieces: Sequence[str], rules: Rules) -> list[str]:
    """Pieces that say something, without the words that order them."""
    bare = [rules.ordering.sub(" ", piece).strip(_ENDS) for piece in pieces]
    return [piece for piece in bare if piece and rules.filler.sub(" ", piece).strip(_ENDS + "'’")]
