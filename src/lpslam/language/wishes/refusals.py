"""Wishes that refuse something: what serves the one part of them, less what serves the other."""

import re
from collections.abc import Callable, Mapping
from dataclasses import replace

from lpslam.language.choosing.guessing import LEAST_SURE
from lpslam.language.wishes.form import Stop
from lpslam.language.wishes.rules import content_left, rules_of
from lpslam.language.wishes.served import Served, Way

_ALIKE = 0.9  # of the best score: what serves what is refused, or what is left of what is wanted, as well
_EQUAL = 0.97  # of the best score: what serves what is wanted as well
_UNEXPLAINED = 0.5  # probability of one of several that serve, where it is not known what is refused
_LEAST_REFUSED = 0.4  # probability that a place is what is refused, from which it is left out
_EACH = re.compile(r"[,，、;] ?|(?: |^)(?:ni|nor|or|noch|und|oder|et|ou|y|o|and)(?: |$)|[和或とや]|(?:이나|하고) ")
_ENDS = " .。!！?？,，、;；:"
ALL_REFUSED = "all that serves is refused"
_NO = re.compile(
    r"^(?:(?:and|or|y|o|et|ou|und|oder) )?(?:(?:not|no|nothing|neither|without|anything|nada|sin|ni|tampoco|nicht"
    r"|nichts|kein(?:e[nmrs]?)?|ohne|pas|rien|sans|surtout|bitte|please)\b[ '’]*"
    r"|(?:with|from|in|de|con|mit|aus|d|avec)\b[ '’]+|(?:也|还有|都)?(?:不要|不是|不想|不吃|不喝|不去|别))+"
)
"""A negation said once more: “nothing frozen and nothing with gluten”."""


def parted(text: str, language: str) -> tuple[str, list[str]] | None:
    """Return what a text wants, and each thing that it refuses; None where no word parts them."""
    rules = rules_of(language)
    found = rules.first((*rules.refusals, *rules.exclusions), text.strip(_ENDS))
    if found is None:
        return None
    groups = found[1].groupdict()
    # “Clothes, not for women but for men”: what is said after the refusal is wanted as well.
    what = " ".join(each.strip(_ENDS) for each in (groups["what"], groups.get("rest", "")) if each)
    out = groups["not"].strip(_ENDS)
    named = (_NO.sub("", each.strip(_ENDS)) for each in _EACH.split(out) if each)
    refused = [each for each in named if content_left(each, rules)]
    return (what, refused) if refused and content_left(what, rules) else None


def left_of(
    served: Served,
    language: str,
    serve: Callable[[Stop], Served],
    bearing: Callable[[str], Mapping[int, float]],
    is_understood: Callable[[Stop], bool],
) -> Served:
    """Return what serves the part of a stop that wants, less what is refused; `served` where that is nothing.

    Args:
        served: what serves the whole stop, unsure or nothing.
        language: of the stop.
        serve: answers a stop.
        bearing: by landmark, how much of its board is said by a text.
        is_understood: whether a stop's words are words for a place at all, here or elsewhere.
    """
    parts = parted(served.stop.what, language)
    if parts is None:
        return served
    what, refused = parts
    is_sure = bool(served.scores) and served.sure >= LEAST_SURE
    wanted = served if is_sure else serve(replace(served.stop, what=what, kinds=(), refused=()))
    if not wanted.scores or wanted.sure < LEAST_SURE:
        return served
    top = max(wanted.scores.values())
    are_several = sum(score >= _EQUAL * top for score in wanted.scores.values()) > 1
    out: set[int] = set()
    for each in refused:
        not_this = serve(replace(served.stop, what=each, kinds=(), refused=()))
        is_found = bool(not_this.scores) and not_this.sure >= (LEAST_SURE if is_sure else _LEAST_REFUSED)
        borne = bearing(each)
        is_told = is_found and not_this.way is not Way.GUESS
        is_explained = bool(is_told or borne or served.stop.refused) or is_understood(not_this.stop)
        if not is_explained and (are_several if is_sure else not is_found):
            # What is refused by words that nothing explains may be any of those that are wanted.
            return replace(served, sure=_UNEXPLAINED) if is_sure else served
        best = max(not_this.scores.values(), default=0.0)
        out.update(borne)
        out.update(id_ for id_, score in not_this.scores.items() if is_found and score >= _ALIKE * best)
    if out.isdisjoint(wanted.scores):
        # Nothing here is refused: then it is not known what was meant by it.
        return served if is_sure else replace(wanted, stop=served.stop)
    # What comes far behind what is refused is not what was wanted.
    left = {id_: score for id_, score in wanted.scores.items() if id_ not in out and score >= _ALIKE * top}
    if not left:
        return replace(served, scores={}, evidence=ALL_REFUSED) if is_sure else served
    best = max(left.values())
    exact = wanted.exact - out
    return replace(wanted, stop=served.stop, scores={id_: each / best for id_, each in left.items()}, exact=exact)
