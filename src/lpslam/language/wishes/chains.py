"""Plans that are told as a chain: clauses that are joined one after the other, each for a place of its own.

“표 사고, 짐 맡기고, 커피 마시자”, 切符を買って、荷物を預けて, “sacar dinero, comprar un libro y tomar un café”: each
language has its `joints`, after which the next clause begins. Whether the pieces are stops their words say, or the map.
"""

from collections.abc import Sequence

from lpslam.language.languages import CAPITALS_ARE_NAMES
from lpslam.language.questions.question import read_question
from lpslam.language.questions.wanted import MAIN
from lpslam.language.tables.knowledge import Knowledge
from lpslam.language.tables.patterns import standing
from lpslam.language.wishes.codes import asked_codes
from lpslam.language.wishes.rules import content_left, rules_of

_LISTED = standing(r"[,，;；、] ?(?:(?:and|und|et|y) )?")
_JOINED = standing(r" (?:and|und|et|y|e) ")
_ANY_KIND = frozenset({"shop", "place", "business"})  # kinds that say nothing of what is wanted
FEWEST_LISTED = 3  # things that are listed without a word for their order: “pharmacy, bank, coffee”
_NUMBER = standing(r"[A-Za-z]?\d{1,4}[A-Za-z]?")
_ENDS = " .。!！?？,，、;；¿¡"
_MOST_LETTERS = 60  # of a piece: longer ones tell of something


def chained(text: str, languages: Sequence[str]) -> list[str]:
    """Return the pieces of a text between the joints of the first language that has any; one without."""
    for language in languages[:1]:
        rules = rules_of(language)
        said = [piece for each in rules["joints"].split(text) if (piece := each.strip(_ENDS))]
        # “豆腐買って帰る”: that one goes then is no stop.
        pieces = _with_codes(said if not said or content_left(said[-1], rules) else said[:-1])
        if len(pieces) > 1 and all(len(piece) <= _MOST_LETTERS for piece in pieces):
            return pieces
    return [text]


def _with_codes(pieces: Sequence[str]) -> list[str]:
    """Pieces of which none is but the number of what the one before says: “to my room, 212”."""
    joined: list[str] = []
    for piece in pieces:
        is_number = bool(joined) and _NUMBER.fullmatch(piece) is not None and not asked_codes(joined[-1])
        if is_number and any(code.of for code in asked_codes(f"{joined[-1]} {piece}")):
            joined[-1] += f" {piece}"
        else:
            joined.append(piece)
    return joined


def pieces_of(text: str, languages: Sequence[str], knowledge: Knowledge) -> list[str]:
    """The stops that a part of a plan names, each something of its own; the part itself where it names one."""
    chain = chained(text, languages)
    for pieces in (chain, listed_in(text, knowledge)):
        if len(pieces) > 1 and are_things(pieces, knowledge):
            return pieces
    return [text]


def finer_pieces(text: str, language: str) -> list[str]:
    """What a part of a plan may list: “lock up my bicycle, enrol, get lunch”; whether it does is for the map to say."""
    rules = rules_of(language)
    pieces = chained(text, (language,))
    return pieces if all(content_left(piece, rules) for piece in pieces) else [text]


def says_a_place(text: str, knowledge: Knowledge) -> bool:
    """Whether a part of a question may be a stop: it wants something or bears a name."""
    read = read_question(text, knowledge)
    return bool(read.wanted) or any(ch.isupper() or ch.isdigit() for ch in text)


def says_a_kind(text: str, languages: Sequence[str], knowledge: Knowledge, least: float = MAIN) -> bool:
    """Whether a text says which kind or name of place, and more than “which shop”, “what is straight”."""
    wanted = read_question(text, knowledge).wanted
    is_name = languages[0] in CAPITALS_ARE_NAMES and any(word[0].isupper() for word in text.split()[1:])
    return is_name or any(weight >= least and kind not in _ANY_KIND for kind, weight in wanted)


def listed_in(text: str, knowledge: Knowledge) -> list[str]:
    """The stops that a part of a plan lists: “buy a ticket, grab a croissant”, each something of its own."""
    lists = (pieces for pieces in lists_in(text) if len(pieces) > 1 and are_things(pieces, knowledge))
    return next(lists, [text])


def lists_in(text: str) -> tuple[list[str], ...]:
    """How a text may be parted: by marks and a last “and”, by marks, and by “and” between words."""
    marked = _with_codes([each for each in _LISTED.split(text) if each.strip(_ENDS)])
    last = [each for each in _JOINED.split(marked[-1]) if each.strip(_ENDS)] if len(marked) > 1 else []
    joined = [each for each in _JOINED.split(text) if len(each.split()) > 1]
    return ([*marked[:-1], *last], marked, joined)


def are_things(pieces: Sequence[str], knowledge: Knowledge) -> bool:
    """Whether each piece wants something of its own, or bears a code or name, and refuses nothing."""
    reads = [read_question(piece, knowledge) for piece in pieces]
    wanted = [{concept for concept, weight in read.wanted if weight >= MAIN} for read in reads]
    apart = len(set().union(*wanted)) == sum(map(len, wanted))
    says = all(mine or asked_codes(piece) for mine, piece in zip(wanted, pieces, strict=True))
    return says and apart and not any(read.refused or read.refused_names for read in reads)
