"""What a sign says: the kinds of place that its words stand for (landmark judgement, III-G)."""

from collections.abc import Mapping, Sequence
from functools import cached_property, lru_cache

from lpslam.language.model import LINES_APART
from lpslam.language.questions.speaking import languages_of
from lpslam.language.questions.wanted import is_eaten
from lpslam.language.sanitise import clean_text
from lpslam.language.signs.meaning import (
    SELDOM,
    SLOGAN,
    SignMeaning,
    Warnings,
    as_a_house,
    as_unknown,
    is_mostly_slogan,
    joined,
    of_known,
    places_in,
    reads_like_a_name,
    said_in,
    share_covered,
    weighed,
    without_stray_letters,
)
from lpslam.language.signs.repair import Repair
from lpslam.language.tables.knowledge import Knowledge, load_knowledge, load_words
from lpslam.language.tables.lexicon import Meaning
from lpslam.language.tables.painted import Known
from lpslam.language.tables.patterns import standing
from lpslam.language.tables.spelling import NearestNames, allowed_edits
from lpslam.language.tables.words import Span, is_mark, is_unspaced, longest_phrases

_PARTS = standing(r"[()\[\]{}<>|/·•:;—–]+|\s-\s")
_PERSON = standing(r"(?:Prof|Dr|Dra|Mr|Mrs|Ms|Sr|Sra|Mme)\.\s?(?:\w+\.\s?)*[A-ZÀ-Þ]")
_SHORTEST_IDEOGRAPHS, _SHORTEST_LETTERS = 3, 6  # of a brand at the head of a longer name; shorter ones are chance
_SHORTEST_TAIL = 2  # ideographs of what a longer name ends with: most kinds of shop have so many
_SURE_TRADE = 0.95  # of a trade at the end of a long name
_JOINS = str.maketrans("", "", "-/")
_COMPOUND = 9  # letters of a word that may be a compound in a name of several words


_QUESTIONS = 64  # whose brands are kept: one and its parts, and a few that are asked at one time
_MOST_DOMAINS = 2.0  # sorts of business that one sign may be wholly

_REPAIR = "shop/repair"
_POURED = frozenset({"wine", "alcohol", "tea", "coffee", "drink"})


class SignReader:
    """Reads signs against the tables; keeps what it has read."""

    def __init__(self, knowledge: Knowledge) -> None:
        self._knowledge = knowledge
        self._fold = knowledge.folder
        self._warnings = Warnings(knowledge)
        self.repair = Repair(knowledge)
        self._glued = {phrase.replace(" ", ""): phrase for phrase in knowledge.painted if " " in phrase}
        self.read = lru_cache(maxsize=65536)(self._read)
        self.phrase = lru_cache(maxsize=65536)(lambda name: self._fold.phrase(clean_text(name)))
        self.brands_in = lru_cache(maxsize=_QUESTIONS)(self._brands_in)

    @cached_property
    def _nearest(self) -> NearestNames:
        return NearestNames(self._knowledge.known)

    @cached_property
    def _wares(self) -> frozenset[str]:
        """What is sold: the goods, and the dishes and drinks, that a kind of shop or kitchen offers first of all."""
        sellers = ("shop/", "amenity/cafe", "amenity/restaurant", "amenity/fast_food", "cuisine/")
        first = {concept: next(iter(table), "") for concept, table in self._knowledge.offers.items()}
        sold = frozenset(each for each, seller in first.items() if "/" not in each and seller.startswith(sellers))
        return sold - self._knowledge.people - {"baby"}

    @cached_property
    def _skeletons(self) -> dict[str, Known]:
        found: dict[str, Known] = {}
        for key, known in self._knowledge.known.items():
            found.setdefault(self._fold.skeleton(key), known)
        return found

    @cached_property
    def _names(self) -> dict[str, list[str]]:
        names: dict[str, list[str]] = {}
        for known in self._knowledge.known.values():
            if known.source == "brand":
                names.setdefault(known.identity, []).append(known.painted)
        return names

    def _read(self, name: str) -> SignMeaning:
        """Return the meaning of one painted name; brackets and dashes part it, a warning in any part decides."""
        text = clean_text(name)
        if LINES_APART in text:
            return self._read_board(text.split(LINES_APART))
        parts = [part for part in (piece.strip() for piece in _PARTS.split(text)) if part]
        if len(parts) > 1 and _PERSON.match(text):
            # Who “Dr. Schneider – Orthopaedics” is called says nothing of what is done there.
            parts = [part for part in parts if not _PERSON.match(part)] or parts
        if len(parts) > 1 and self._fold.key(text) not in self._knowledge.known:
            return joined([self._read_part(part) for part in parts])
        return self._read_part(text)

    def _read_board(self, lines: Sequence[str]) -> SignMeaning:
        """Return what the lines of a board say together, and else what one of them says: a shop may have a slogan.

        A warning may go over several lines; only a known name on a line of its own is none.
        """
        whole = self._read(" ".join(lines))
        if whole.is_place:
            return whole
        told = [self._read(line) for line in lines]
        surest = max(told, key=lambda line: (line.is_place, max((weight for _, weight in line.kinds), default=0.0)))
        if not surest.is_place or any(line.warns for line in told) or (whole.warns and surest.identity is None):
            return whole
        return surest

    def listed(self, thing: str) -> SignMeaning | None:
        """Return what a thing that a line lists means, by its words alone: in a list “Boots” are no brand."""
        text = clean_text(thing)
        units = self._fold.sign_units(text)
        units = self.repair.repaired(units, bool(self._phrases("", units)))
        key = "".join(unit for unit in units if not is_mark(unit))
        spans = self._phrases(key, units)
        if self._warnings.read(text, key, units, spans) is not None:
            return None
        # “Shoe repairs while you wait” advertises what is done behind the board.
        spans = [span for span in spans if all(kind != SLOGAN for kind, _ in span.value.concepts)]
        found = self._as_words(text, key, units, spans) or self._as_few_words(text, units, spans)
        return found if found is not None and found.is_place else None

    def names_of(self, identity: str) -> tuple[str, ...]:
        """Return every name under which a brand is known."""
        return tuple(self._names.get(identity, ()))

    def _brands_in(self, question: str) -> Mapping[str, str]:
        """Return {phrase: identity} of the brands that a question mentions; a plain word of the language is none."""
        fold = self._fold
        spoken = [self._knowledge.spoken(language) for language in languages_of(question, self._knowledge)[:1]]
        units, folded = fold.units(question), fold.fold(question).replace(" ", "")
        # “We're” has no capital but its first letter.
        capital = {unit for word in question.split()[1:] if word[:1].isupper() for unit in fold.units(word)[:1]}
        found: dict[str, str] = {}
        for at in range(len(units)):
            if units[at][0] not in "-/" and not (is_unspaced(units[at]) or units[at] in capital or units[at].isdigit()):
                continue
            for end in range(at + 1, min(len(units), at + 6) + 1):
                # 7-11 has a mark inside.
                phrase, key = " ".join(units[at:end]), "".join(units[at:end]).translate(_JOINS)
                if (is_unspaced(key) and len(key) < 3) or (
                    not is_unspaced(key) and units[at] not in capital and not units[at].isdigit()
                ):
                    continue
                # Units have lost a plural's ending, which Starbucks keeps.
                known = self._known_brand(key) or (self._known_brand(f"{key}s") if f"{key}s" in folded else None)
                if (
                    known is not None
                    and phrase not in self._knowledge.painted
                    and not any(phrase in table and not _is_its_own(table[phrase], known) for table in spoken)
                ):
                    found[phrase] = known.identity
        return found

    def nearest(self, key: str) -> list[tuple[int, Known]]:
        """Return (edits, known name) of the names nearest to `key`: an exact or look-alike one, or all at one distance.

        Empty where none is within the edits that the length allows.
        """
        exact = self._knowledge.known.get(key)
        if exact is None and len(key) > 2:
            exact = self._skeletons.get(self._fold.skeleton(key))
        if exact is not None:
            return [(0, exact)]
        near = self._nearest.near(key, allowed_edits(key))
        return [(distance, self._knowledge.known[other]) for distance, other in near if distance == near[0][0]]

    def _nearest_meaning(self, key: str) -> tuple[int, Known] | None:
        """Return a nearest name if all of them mean the same: then it does not matter which of them was painted."""
        near = self.nearest(key)
        return near[0] if len({known.kinds for _, known in near}) == 1 else None

    def _read_part(self, text: str) -> SignMeaning:
        """Ask in turn: a brand, a warning, words of places or slogans, a misread known name, or just a name."""
        key = self._fold.key(text)
        if sum(ch.isalpha() for ch in key) < 2:
            return SignMeaning((), f"“{text}” has too few letters to say anything")
        units = self._fold.sign_units(text)
        spans = self._phrases(key, units)
        certain = (
            self._as_brand(text, key, units)
            or self._warnings.read(text, key, units, spans)
            or self._as_brand_with_words(text, units, spans)
        )
        if certain:
            return certain
        read = self.repair.repaired(units, bool(spans))
        if read != units:
            units, key = read, "".join(unit for unit in read if not is_mark(unit))
            spans = self._phrases(key, units)
        return (
            self._as_words(text, key, units, spans)
            or self._as_misread(text, key)
            or self._as_few_words(text, units, spans)
            or as_unknown(text, units)
        )

    def _as_brand(self, text: str, key: str, units: Sequence[str]) -> SignMeaning | None:
        known = self._known_brand(key)
        plain = self._knowledge.painted.get(" ".join(units))
        # “Sale” and “Open” are brands somewhere, but not on most doors.
        if known is None or (plain is not None and plain.role == "sign"):
            return None
        return of_known(known, 1.0, f"“{text}” is {known.painted}")

    def _as_brand_with_words(
        self, text: str, units: Sequence[str], spans: Sequence[Span[Meaning]]
    ) -> SignMeaning | None:
        brand = self._brand_within(text, units, spans)
        if brand is None:
            return None
        known, share, end = brand
        # The letters of the brand say nothing else: 大福, in 周大福珠宝, is no cake.
        spans = self._phrases("", units[end:])
        if self._fold.key(known.painted) in load_words() and self._say_otherwise(spans, known):
            return None
        told = f"“{text}” begins with {known.painted}"
        return of_known(known, 0.9 * share, told, self._offered(weighed(spans)))

    def _say_otherwise(self, spans: Sequence[Span[Meaning]], known: Known) -> bool:
        """Whether the words after a brand that is an everyday word say another trade: “Green Leaf Vegetarian”."""
        said = set(self._offered(places_in(weighed(spans)))) - self._knowledge.general
        own = {each for kind, _ in known.kinds for each in self._special_above(kind)}
        return bool(said) and not any(own.intersection(self._special_above(kind)) for kind in said)

    def _special_above(self, kind: str) -> set[str]:
        """A kind and the kinds above it that say more than “a shop”."""
        return {each for each in self._knowledge.above(kind) if "/" in each or each == kind}

    def _as_words(
        self, text: str, key: str, units: Sequence[str], spans: Sequence[Span[Meaning]]
    ) -> SignMeaning | None:
        kinds = as_a_house(self._repairing(weighed(spans)), self._wares)
        places = places_in(kinds)
        if SLOGAN in kinds and (
            self._knowledge.general.issuperset(places) or len(units) > 4 or is_mostly_slogan(spans)
        ):
            return SignMeaning(((SLOGAN, 0.8),), f"“{text}” has words of a slogan or notice")
        covered = share_covered(spans, units)
        if not places or (key not in self._knowledge.known and covered < 0.3):
            return None
        own_name = covered <= 0.5 and reads_like_a_name(text, units)
        told = f"“{text}” says {said_in(spans)}"
        kinds_of = self._spread(self._offered(places), spans)
        return SignMeaning(kinds_of, told, name_like=own_name)

    def _spread(self, kinds: dict[str, float], spans: Sequence[Span[Meaning]]) -> tuple[tuple[str, float], ...]:
        """A sign that claims everything (“coffee pizza wc shoes bank”) is each of it the less surely."""
        domains = {self._domain(span.value.concepts[0][0]) for span in spans if span.value.concepts}
        share = min(1.0, _MOST_DOMAINS / max(len(domains), 1))
        return tuple((kind, share * weight) for kind, weight in kinds.items())

    def _domain(self, concept: str) -> str:
        """What sort of business a concept belongs to: all food is one, all goods of shops are one."""
        if is_eaten(concept, self._knowledge) or concept.startswith(("cuisine/", "aisle/")):
            return "food"
        first = concept if "/" in concept else next(iter(self._knowledge.offers.get(concept, ())), concept)
        return "shop" if first.startswith("shop/") else "/".join(first.split("/")[:2])

    def _repairing(self, kinds: dict[str, float]) -> dict[str, float]:
        """Who repairs and names a good repairs that: a watchmaker mends no telephones."""
        if _REPAIR not in kinds:
            return kinds
        own = {f"{good}_repair": weight for good, weight in kinds.items() if f"{good}_repair" in self._knowledge.offers}
        return kinds | own | {_REPAIR: SELDOM} if own else kinds

    def _as_misread(self, text: str, key: str) -> SignMeaning | None:
        near = self._nearest_meaning(key)
        if near is None:
            return None
        distance, known = near
        return of_known(known, 0.9 - 0.1 * distance, f"“{text}” looks like a misread {known.painted}")

    def _as_few_words(self, text: str, units: Sequence[str], spans: Sequence[Span[Meaning]]) -> SignMeaning | None:
        offered = self._offered(places_in(weighed(spans)))
        if not offered:
            return None
        # A trade ends a name, or leads it: “The Oak Tree Restaurant”.
        words = [at for at, unit in enumerate(units) if not is_mark(unit)]
        is_trade = spans[-1].end > words[-1] or (spans[0].start == 0 and spans[0].key in self._knowledge.leading)
        sure = _SURE_TRADE if is_trade else 0.7
        kinds = tuple((kind, sure * weight) for kind, weight in offered.items())
        return SignMeaning(kinds, f"“{text}” says {said_in(spans)}")

    def _phrases(self, key: str, units: Sequence[str]) -> list[Span[Meaning]]:
        spans = longest_phrases(units, (self._knowledge.painted,))
        if len(units) > 1:
            # Without its accent, thé is the English article.
            spans = [span for span in spans if span.key not in self._knowledge.articles]
        if spans:
            return without_stray_letters(spans, units)
        # The reader may have lost the spaces: then the whole, or its first or last word, is looked for glued.
        whole = self._glued.get(key)
        if whole is not None:
            return [Span(0, len(units), whole, self._knowledge.painted[whole])]
        for at, unit in enumerate(units):
            found = self._piece_of(unit) if len(units) == 1 or len(unit) >= _COMPOUND else None
            if found is not None:
                return [Span(at, at + 1, *found)]
        return []

    def _piece_of(self, unit: str) -> tuple[str, Meaning] | None:
        """The longest known beginning or end of a word: “Spielzeugkiste” sells toys."""
        for size in range(len(unit) - 3, 4, -1) if unit.isascii() else ():
            for piece in (unit[-size:], unit[:size]):
                meaning = self._knowledge.painted.get(self._glued.get(piece, piece))
                if meaning is not None:
                    return piece, meaning
        return None

    def _brand_within(
        self, text: str, units: Sequence[str], spans: Sequence[Span[Meaning]]
    ) -> tuple[Known, float, int] | None:
        """Return a brand that the sign begins with (“Nike Factory Store”, 必胜客欢乐餐厅), exactly or nearly.

        And how sure that is, and where in the units it ends.
        """
        ends = [at + 1 for at, unit in enumerate(units) if not is_mark(unit)]
        words = [units[end - 1] for end in ends]
        plain = {word for span in spans for word in span.key.split()}
        for end in range(len(words) - 1, 0, -1):
            head = "".join(words[:end])
            shortest = 2 if is_unspaced(head) else 3
            if len(head) < shortest or (end == 1 and head in plain):
                continue
            known = self._known_brand(head) or self._known_brand(self._fold.key(" ".join(text.split()[:end])))
            if known is not None:
                return known, 1.0, ends[end - 1]
        for end in range(len(words) - 1, 2, -1):
            head = "".join(words[:end])
            after = [span for span in spans if span.start >= ends[end - 1]]
            if is_unspaced(head) and after:
                near = self._nearest_meaning(head)
                if near is not None and near[1].source == "brand" and not self._say_otherwise(after, near[1]):
                    return near[1], 0.8, ends[end - 1]
        return self._brand_in_the_other_script(ends, words)

    def _brand_in_the_other_script(self, ends: Sequence[int], words: Sequence[str]) -> tuple[Known, float, int] | None:
        """Return the brand of a sign that repeats a name which is not known in Latin letters: “達美樂 Domino's”."""
        latin = next((at for at, word in enumerate(words) if not is_unspaced(word)), 0)
        tail = "".join(words[latin:])
        if latin == 0 or len(tail) < _SHORTEST_LETTERS or any(map(is_unspaced, words[latin:])):
            return None
        known = self._known_brand(tail) or self._known_brand(f"{tail}s")
        return (known, 1.0, ends[-1]) if known is not None else None

    def brand_head(self, key: str) -> int:
        """Return how many letters of a key are a brand that it begins with, and goes on after; 0 without one."""
        shortest = _SHORTEST_IDEOGRAPHS if is_unspaced(key) else _SHORTEST_LETTERS
        ends = range(len(key) - 1, shortest - 1, -1)
        return next((end for end in ends if self._known_brand(key[:end]) is not None), 0)

    def known_tail(self, key: str) -> int:
        """Return how many letters in a script without spaces are a known name that a key ends with: B1停车场.

        What is before them may be of any script; Latin letters after Chinese are a name of their own.
        """
        begin = len(key)
        while begin > 0 and is_unspaced(key[begin - 1]):
            begin -= 1
        begins = range(max(begin, 1), len(key) - _SHORTEST_TAIL + 1)
        return next((len(key) - begin for begin in begins if key[begin:] in self._knowledge.known), 0)

    def _known_brand(self, key: str) -> Known | None:
        known = self._knowledge.known.get(key)
        return known if known is not None and known.source == "brand" else None

    def _offered(self, kinds: dict[str, float]) -> dict[str, float]:
        """Add to the goods a sign names the kinds of shop that sell them first of all."""
        offered = dict(kinds)
        is_kitchen = any(kind.startswith(("cuisine/", "amenity/restaurant")) for kind in kinds)
        for concept, weight in kinds.items():
            if is_kitchen and concept in _POURED:
                # “Tapas y vino” is no wine shop.
                continue
            for kind, share in self._knowledge.offers.get(concept, {}).items():
                if share >= 0.95 and not kind.startswith("trait/"):
                    offered.setdefault(kind, 0.85 * weight * share)
        return offered


def _is_its_own(meaning: Meaning, known: Known) -> bool:
    """Whether a phrase means what a brand of that name sells: then it is the brand, and no word of the language."""
    own = {kind for kind, _ in known.kinds}
    return all(concept in own for concept, _ in meaning.concepts)


@lru_cache(maxsize=1)
def load_sign_reader() -> SignReader:
    """Return the reader over the package's own tables, built once a process."""
    return SignReader(load_knowledge())
