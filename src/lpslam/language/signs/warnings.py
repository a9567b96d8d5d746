"""Whether a sign warns or forbids, and so is no destination."""

from collections.abc import Sequence

from lpslam.language.signs.meaning import SignMeaning
from lpslam.language.signs.wording import TRADES, WARNING, forbids, weighed
from lpslam.language.tables.knowledge import Knowledge
from lpslam.language.tables.lexicon import Meaning
from lpslam.language.tables.words import Span, is_mark, is_unspaced

_HOUSES = ("shop/", "amenity/", "leisure/", "cuisine/", "craft/", "tourism/")
_SHOP_ENDS = frozenset("店馆屋坊铺舗")


class Warnings:
    """Reads warnings by how they begin and by their words."""

    def __init__(self, knowledge: Knowledge) -> None:
        self._knowledge = knowledge
        self._starts = tuple(
            start.replace(" ", "") for start in knowledge.warning_starts if len(start) >= 6 or is_unspaced(start)
        )

    def read(self, text: str, key: str, units: Sequence[str], spans: Sequence[Span[Meaning]]) -> SignMeaning | None:
        """Return what a sign that warns means; None where it does not."""
        if self._ends_in_a_trade(units, spans):
            return None
        start = self._warning_start(key, units)
        if start is not None:
            return SignMeaning(((WARNING, 0.95),), f"“{text}” begins like a warning (“{start}”)")
        if forbids(text, units, spans):
            return SignMeaning(((WARNING, 0.95),), f"“{text}” forbids something")
        if WARNING in weighed(spans):
            return SignMeaning(((WARNING, 0.95),), f"“{text}” has words of a warning")
        return None

    def _ends_in_a_trade(self, units: Sequence[str], spans: Sequence[Span[Meaning]]) -> bool:
        """Whether a sign names a danger only to name a shop after it: “Danger Zone Games”.

        What asks or forbids (“No food”, “Keep off the furniture”) is no name, and goods that one is warned of (coffee,
        water, glass) are no trade.
        """
        words = [at for at, unit in enumerate(units) if not is_mark(unit) and unit not in self._knowledge.company_forms]
        if not words or not spans or units[words[0]] in self._knowledge.imperatives:
            return False
        if is_unspaced(units[words[0]]):
            # 勿忘我花店 begins with a “don't”, and says no more of what must not be done.
            whole = " ".join(units)
            forbids = any(whole.startswith(start) for start in self._knowledge.forbidding)
            kinds = [concept for concept, _ in spans[-1].value.concepts]
            is_house = any(kind.startswith(_HOUSES) for kind in kinds) or units[words[-1]] in _SHOP_ENDS
            return not forbids and is_house and spans[-1].end > words[-1] and spans[-1].end - spans[-1].start > 1
        return spans[-1].end > words[-1] and any(
            concept in self._knowledge.trade_goods or concept.startswith(TRADES)
            for concept, _ in spans[-1].value.concepts
        )

    def _warning_start(self, key: str, units: Sequence[str]) -> str | None:
        for end in range(min(4, len(units)), 0, -1):
            phrase = " ".join(units[:end])
            if phrase in self._knowledge.warning_starts and (len(units) > end or end > 1):
                return phrase.replace(" ", "") if is_unspaced(phrase) else phrase
        if not key.startswith(self._starts):
            return None
        return next((start for start in self._starts if key.startswith(start) and key != start), None)
