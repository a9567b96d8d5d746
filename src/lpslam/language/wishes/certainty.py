"""What tells how sure it is that what the tables found is what was meant.

How the best landmark was found, by how much it leads, and how much of the question says so; `choosing/guessing.py`
judges it together with what guesses know.
"""

import math

from lpslam.language.choosing.landmark_index import LandmarkIndex
from lpslam.language.choosing.serving import FITS, best_of, likeness, match
from lpslam.language.choosing.support import CLUES
from lpslam.language.questions.question import read_part
from lpslam.language.tables.knowledge import Knowledge
from lpslam.language.tables.states import together_in
from lpslam.language.tables.words import is_mark, longest_phrases
from lpslam.language.wishes.asked_words import AskedWords
from lpslam.language.wishes.form import Which
from lpslam.language.wishes.served import Served, Way

_RIVALS = 0.97  # of the best score: what serves as well
_MOST_UNITS = 20  # units of a question that count as many


def clues_of(served: Served, index: LandmarkIndex, asked: AskedWords, knowledge: Knowledge) -> dict[str, float]:
    """Return what tells how sure it is that the best of what serves is what was meant, each about 0 to 1."""
    text = served.stop.what
    wish = read_part(text, served.stop.language, knowledge)
    best = best_of(served.scores)
    top = served.scores[best]
    kinds = index.signs[best].kinds
    stop = served.stop
    # What a place, an order or an exclusion tells apart are no rivals.
    is_told = stop.relation is not None or stop.which is not Which.ANY or bool(stop.without)
    rivals = {} if is_told else served.scores
    group_of = index.group_of
    group = group_of[best]
    others = [score for id_, score in rivals.items() if group_of[id_] != group]
    ties = {group, *(group_of[id_] for id_, score in rivals.items() if score >= _RIVALS * top)}
    meant = {concept: weight for concept, weight in wish.wanted if match(concept, kinds, knowledge) >= FITS}
    language = wish.language or next(iter(asked.likely(text)), "en")
    units = knowledge.folder.units(text)
    common = knowledge.common.get(language, frozenset())
    own = [at for at, unit in enumerate(units) if not is_mark(unit) and unit not in common]
    known: set[int] = set()
    telling: set[int] = set()
    longest, several = 0, False
    for span in longest_phrases(units, knowledge.tables_of(language)):
        known.update(range(span.start, span.end))
        if any(concept in meant for concept, _ in span.value.concepts):
            telling.update(range(span.start, span.end))
            longest = max(longest, min(len(span.key), 20))
            several = several or span.end - span.start > 1
    for together in together_in(units, knowledge.states(language)):
        known.update(together.units)
        if together.concept in meant:
            telling.update(together.units)
            several = True
    words = max(len(own), 1)
    weight = dict(wish.wanted)
    direct = max((weight[each] * likeness(each, kinds, knowledge) for each in meant), default=0.0)
    offered = max((weight[each] * match(each, kinds, knowledge) for each in meant), default=0.0)
    is_kind = served.way is Way.KIND
    clues = {
        "is one": direct if is_kind else 0.0,
        "offers it": offered if is_kind and not direct else 0.0,
        "longest phrase": longest / 10.0 if is_kind else 0.0,
        "phrase of several words": float(is_kind and several),
        "unread signs": index.unread,
        "strength": served.strength if is_kind else 0.0,
        "strength of words": served.strength if served.way in (Way.WORDS, Way.NAME) else 0.0,
        "lead by tables": (top - max(others, default=0.0)) / top,
        "rivals": math.log(len(ties)),
        "says so": sum(at in telling for at in own) / words if is_kind else 0.0,
        "not known": sum(at not in known for at in own) / words,
        "length": math.log1p(min(len(own), _MOST_UNITS)),
        "wants much": math.log1p(len(wish.wanted)),
        "only general": float(bool(meant) and all(each in knowledge.general for each in meant)),
        "sign of many kinds": math.log1p(len(kinds)),
        "brand": float(bool(index.signs[best].identity)),
        "language not told": float(wish.language is None),
    }
    clues |= {name: served.heard.get(name, 0.0) for name in CLUES}
    return clues | {"name": float(served.way is Way.NAME), "guess": float(served.way is Way.GUESS)}
