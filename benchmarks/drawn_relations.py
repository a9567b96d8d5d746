"""Score relations, plans and refusals in worlds that are drawn: what is right follows from how they were drawn.

python benchmarks/drawn_relations.py                          # 60 worlds of seed 0
python benchmarks/drawn_relations.py --seed 7 --misses
python benchmarks/drawn_relations.py --ways third             # other ways of asking; or other
python benchmarks/drawn_relations.py --write FILE.json        # the wishes as a set for `benchmarks/wishes.py`

A world is two rows of boards that face one another across a corridor, turned and shifted at random: shops, offices,
market stalls or departments of one language, some by their kind, some by a name or number, and three places of one
kind (toilets, lifts). What is asked is decided by the drawing alone (who is the next in the row, who stands across, who
is nearest by a clear margin), never by the program's own code, and only where nobody would answer otherwise. The words
are in `benchmarks/language/drawn_relations.json`.
"""

import argparse
import json
import math
import random
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from drawn_names import LANGUAGES, LATIN_SHOP, UNSPACED, write_or_score
from drawn_names import WORDS as NAMES

WORDS: dict[str, Any] = json.loads(
    (Path(__file__).parent / "language" / "drawn_relations.json").read_text(encoding="utf-8")
)
ORDER = ("en", "de", "fr", "es", "zh", "ja", "ko")
"""Languages of a noun's line."""
ACROSS, NOT_ACROSS = 1.0, 2.2  # metres along the row: what stands across, and what does not any more
NEARER, LESS_DETOUR = 2.5, 4.0  # metres by which one must be nearer, or the smaller detour, than another
_OF_ANY = ("next to", "opposite", "side", "between")  # whatever stands there
_GENDERED = {
    # Of German, by gender: der, dative, accusative, ein (accusative), einem, endings of welch-, nächst-, ander-.
    "m": ("der", "dem", "den", "einen", "einem", "er", "e", "en"),
    "f": ("die", "der", "die", "eine", "einer", "e", "e", "e"),
    "n": ("das", "dem", "das", "ein", "einem", "es", "e", "es"),
}
_SHORT = {"von dem": "vom", "an dem": "am", "zu dem": "zum", "zu der": "zur"}
_DE = {"fr": {"m": "du ", "f": "de la ", "": "de "}, "es": {"m": "del ", "f": "de la ", "": "de "}}
_TO = {"fr": {"m": "au ", "f": "à la ", "": "à "}, "es": {"m": "al ", "f": "a la ", "": "a "}}
_THE = {"fr": {"m": "le ", "f": "la ", "": ""}, "es": {"m": "el ", "f": "la ", "": ""}}


@dataclass(frozen=True)
class Noun:
    """A word for a place: its gender, where its language has one; none where it is a name."""

    word: str
    gender: str
    language: str

    def forms(self) -> dict[str, str]:
        """How it stands in a sentence, by slot."""
        makers: dict[str, Callable[[], dict[str, str]]] = {
            "en": self._english, "de": self._german, "fr": self._romance, "es": self._romance, "ko": self._korean,
        }  # fmt: skip
        return {"bare": self.word, "the": self.word, **makers.get(self.language, dict)()}

    def _english(self) -> dict[str, str]:
        an = "an" if self.word[0].lower() in "aeiou" else "a"
        return {"the": f"the {self.word}" if self.gender else self.word, "an": f"{an} {self.word}"}

    def _german(self) -> dict[str, str]:
        if not self.gender:
            return dict.fromkeys(("dat", "acc"), self.word) | {
                each: f"{each} {self.word}" for each in ("von", "an", "zu")
            }
        the, dative, accusative, one, to_one, which, near, other = _GENDERED[self.gender]
        forms = {"dat": f"{dative} {self.word}", "acc": f"{accusative} {self.word}", "the": f"{the} {self.word}"}
        for each in ("von", "an", "zu"):
            said = f"{each} {dative}"
            forms[each] = f"{_SHORT.get(said, said)} {self.word}"
        return forms | {
            "article": the, "one": f"{one} {self.word}", "to one": f"{to_one} {self.word}", "which": f"welch{which}",
            "nearest": f"{the} nächst{near} {self.word}", "another": f"{one} ander{other} {self.word}",
        }  # fmt: skip

    def _romance(self) -> dict[str, str]:
        lang, sex = self.language, self.gender
        the, of, to = _THE[lang][sex], _DE[lang][sex], _TO[lang][sex]
        if lang == "fr" and self.word[0].lower() in "aeéèêiou":
            # Before a vowel le and la are l'.
            the, of, to = ("l'", "de l'", "à l'") if sex else ("", "d'", "à ")
        return {
            "article": the, "the": the + self.word, "of": of + self.word, "to": to + self.word,
            "an": f"{'un' if sex == 'm' else 'une' if lang == 'fr' else 'una'} {self.word}",
            "which": f"{'quel' if sex == 'm' else 'quelle'}",
        }  # fmt: skip

    def _korean(self) -> dict[str, str]:
        last = ord(self.word[-1]) - 0xAC00
        closed, is_l = (last % 28 > 0, last % 28 == 8) if 0 <= last < 11172 else (False, False)
        ends = {"wa": "과" if closed else "와", "rang": "이랑" if closed else "랑", "eul": "을" if closed else "를",
                "ro": "으로" if closed and not is_l else "로", "i": "이" if closed else "가"}  # fmt: skip
        return {name: self.word + end for name, end in ends.items()}


def slots(items: list[Noun], generic: Noun, kind: Noun) -> dict[str, str]:
    """All slots of a template: a, b, c are items; g is a word for any place; n the kind that is wanted."""
    filled: dict[str, str] = {"g": generic.word, "n": kind.word, "e": "le" if generic.gender == "f" else ""}
    for letter, number, noun in zip("abc", ("", "2", "3"), items, strict=False):
        forms = noun.forms()
        filled[letter] = forms["the"]
        for name in ("dat", "acc", "von", "an", "zu", "of", "to", "wa", "rang", "eul", "ro"):
            filled[("de" if name == "of" else name) + number] = forms.get(name, noun.word)
        filled[f"{letter}_ro"], filled[f"{letter}_wa"] = forms.get("ro", ""), forms.get("wa", "")
    any_, wanted = generic.forms(), kind.forms()
    filled |= {"dieser": any_.get("article", ""), "rel": any_.get("article", ""), "welcher": any_.get("which", ""),
               "le": any_.get("article", ""), "quel": any_.get("which", ""), "g_ro": any_.get("ro", ""),
               "un": any_.get("an", "").split(" ")[0], "to_g": any_.get("to", ""), "welches": "was",
               "der_n": wanted["the"], "le_n": wanted["the"], "rel_n": wanted.get("article", ""),
               "welcher_n": f"{wanted.get('which')} {kind.word}", "quel_n": f"{wanted.get('which')} {kind.word}",
               "ein_n": wanted.get("one", ""), "dat_n": wanted.get("to one", ""), "un_n": wanted.get("an", ""),
               "der_nahe_n": wanted.get("nearest", ""), "ein_anderer_n": wanted.get("another", ""),
               "n_i": wanted.get("i", ""), "n_eul": wanted.get("eul", "")}  # fmt: skip
    if kind.language == "en":
        filled["an"] = wanted["an"]
    return filled


@dataclass
class Board:
    """One board: what it says, how one speaks of it, where it hangs."""

    name: str
    noun: Noun
    x: float = 0.0
    row: int = 0
    is_several: bool = False


class World:
    """One world while it is drawn."""

    def __init__(self, rng: random.Random, ways: dict[str, Any]) -> None:
        self.rng, self._ways = rng, ways
        self.language = rng.choice(LANGUAGES)
        self.theme = rng.choice(sorted(WORDS["nouns"]))
        self.boards: list[Board] = []
        self.wishes: list[dict[str, Any]] = []
        self.width = rng.uniform(4.0, 7.0)

    def _noun(self, line: str) -> Noun:
        said = line.split("|")[ORDER.index(self.language)]
        if self.language in ("de", "fr", "es"):
            return Noun(said[2:], said[0], self.language)
        return Noun(said, "x", self.language)

    def draw(self) -> dict[str, Any]:
        """Return the world as `benchmarks/wishes.py` has it."""
        single = [self._noun(line) for line in self.rng.sample(WORDS["nouns"][self.theme], 8)]
        self.boards = [Board(noun.word[0].upper() + noun.word[1:], noun) for noun in single]
        named = self._named()
        self.boards += [Board(name, Noun(name, "", self.language)) for name in named]
        kind = self._noun(self.rng.choice(WORDS["several"]))
        is_told = self.rng.random() < 0.5
        own = self.rng.sample(NAMES["own" if self.language in UNSPACED else "people"][self.language], 3)
        title = kind.word[0].upper() + kind.word[1:]
        for at in range(3):
            name = f"{title} {at + 1}" if is_told and kind.word != self._café() else title
            name = f"{title} {own[at]}" if is_told and kind.word == self._café() else name
            self.boards.append(Board(name, Noun(name, "", self.language), is_several=True))
        self.rng.shuffle(self.boards)
        half = len(self.boards) // 2
        for row, part in enumerate((self.boards[:half], self.boards[half:])):
            x = self.rng.uniform(0.0, 3.0)
            for board in part:
                board.x, board.row = x, row
                x += self.rng.uniform(3.5, 7.0)
        self._here = self.rng.uniform(-2.0, 3.0)
        self._ask_all(kind, is_told)
        return self._placed()

    def _café(self) -> str:
        return self._noun(WORDS["several"][1]).word

    def _named(self) -> list[str]:
        own = self.rng.sample(NAMES["own" if self.language in UNSPACED else "people"][self.language], 5)
        if self.theme in ("mall", "market"):
            shape = LATIN_SHOP.get(self.language, "{own}{trade}" if self.language != "ko" else "{own} {trade}")
            # Trades of names are none of the kinds that stand here by themselves, nor one another's.
            words = {board.noun.word.casefold() for board in self.boards} | {self._café().casefold()}
            free = [each for each in NAMES["trades"][self.language] if each.casefold() not in words]
            trades = self.rng.sample(free, 2)
            return [shape.format(own=name, trade=trade) for name, trade in zip(own, trades, strict=False)]
        title = self.rng.choice(NAMES["titles"][self.language])
        room = NAMES["numbered"]["room"][self.language][0]
        return [title.format(s=own[0]), room.format(n=self.rng.randint(101, 420))]

    def _placed(self) -> dict[str, Any]:
        """The boards turned and shifted, and every wish."""
        turn = self.rng.choice((0, 90, 180, 270)) + self.rng.uniform(-10.0, 10.0)
        shift = self.rng.uniform(-30.0, 30.0), self.rng.uniform(-30.0, 30.0)
        cos, sin = math.cos(math.radians(turn)), math.sin(math.radians(turn))

        def point(x: float, y: float) -> list[float]:
            return [round(cos * x - sin * y + shift[0], 2), round(sin * x + cos * y + shift[1], 2)]

        places = [
            {"name": board.name, "position": point(board.x, self.width * board.row),
             "facing": (turn + (90.0 if board.row == 0 else -90.0)) % 360.0}
            for board in self.boards
        ]  # fmt: skip
        return {"places": places, "here": point(self._here, self.width / 2), "wishes": self.wishes}

    def _ask(self, kind: str, items: list[Noun], wanted: Noun, expected: Any, side: int = 0, **more: str) -> None:
        pool = self._ways[kind][self.language]
        several = {self._id(each) for each in self.boards if each.is_several}
        if kind in _OF_ANY and several.intersection([expected] if isinstance(expected, str) else expected or ()):
            # A toilet is no shop and no department.
            pool = [each for each in pool if not any(slot in each for slot in ("{g}", "{g_ro}", "{to_g}"))]
        template = self.rng.choice(pool)
        genus, _, word = self.rng.choice(WORDS["generic"][self.theme][self.language]).partition(" ")
        generic = Noun(word or genus, genus if word else "x", self.language)
        side_words = WORDS["sides"][self.language][side].split("|")
        filled = slots(items, generic, wanted) | {"s": side_words[0], "S": side_words[-1], **more}
        if kind == "plan" and isinstance(expected, list):
            expected = expected[: 3 if any(slot in template for slot in ("{c}", "{zu3}", "{to3}")) else 2]
            category = "plan"
        else:
            category = kind
        question = template.format_map(filled).replace("  ", " ")
        self.wishes.append(
            {"question": question, "expected": expected, "language": self.language, "category": category}
        )

    def _ask_all(self, kind: Noun, is_told: bool) -> None:
        rows = [sorted((each for each in self.boards if each.row == row), key=lambda each: each.x) for row in (0, 1)]
        self._in_rows(rows, kind)
        self._opposite(rows, kind)
        self._by_distance(kind)
        single = [each for each in self.boards if not each.is_several]
        for _ in range(2):
            stops = self.rng.sample(single, 3)
            self._ask("plan", [each.noun for each in stops], kind, [each.name for each in stops])
        if is_told:
            several = [each.name for each in self.boards if each.is_several]
            out = self.rng.choice(several)
            self._ask("refusal", [], kind, [each for each in several if each != out], x=out)
        absent = Noun(self.rng.choice(WORDS["absent"][self.language]), "", self.language)
        before = len(self.wishes)
        self._ask(self.rng.choice(("next to", "opposite", "side")), [absent], kind, None)
        self.wishes[before]["category"] = "anchor that is not here"

    def _id(self, board: Board) -> str:
        return f"{board.name}@{self.boards.index(board)}"

    def _in_rows(self, rows: list[list[Board]], kind: Noun) -> None:
        """Neighbours, sides and what is between, of boards that can be spoken of as one."""
        for row in rows:
            inner = [at for at in range(1, len(row) - 1) if not row[at].is_several]
            at = self.rng.choice(inner)
            both = [self._id(row[at - 1]), self._id(row[at + 1])]
            self._ask("next to", [row[at].noun], kind, both)
            at, side = self.rng.choice(inner), self.rng.randrange(2)
            # Who reads a board of the first row looks down the y axis: left is along x; of the second row against it.
            step = (1 if row[at].row == 0 else -1) * (1 if side == 0 else -1)
            self._ask("side", [row[at].noun], kind, self._id(row[at + step]), side)
            middles = [at for at in range(1, len(row) - 1) if not (row[at - 1].is_several or row[at + 1].is_several)]
            if middles:
                at = self.rng.choice(middles)
                self._ask("between", [row[at - 1].noun, row[at + 1].noun], kind, self._id(row[at]))

    def _opposite(self, rows: list[list[Board]], kind: Noun) -> None:
        asked = 0
        for board in self.rng.sample(self.boards, len(self.boards)):
            apart = sorted((abs(other.x - board.x), self._id(other)) for other in rows[1 - board.row])
            if not board.is_several and asked < 2 and apart[0][0] <= ACROSS and apart[1][0] >= NOT_ACROSS:
                self._ask("opposite", [board.noun], kind, apart[0][1])
                asked += 1

    def _by_distance(self, kind: Noun) -> None:
        """What is nearest to something, on the way to it, or nearer of two."""
        single = [each for each in self.boards if not each.is_several]
        several = [each for each in self.boards if each.is_several]
        for anchor in self.rng.sample(single, 3):
            near = sorted((self._apart(each, anchor), self._id(each)) for each in several)
            if near[1][0] - near[0][0] >= NEARER:
                self._ask("nearest", [anchor.noun], kind, near[0][1])
            by = sorted((self._from_here(each) + self._apart(each, anchor), self._id(each)) for each in several)
            straight = self._from_here(anchor)
            if by[1][0] - by[0][0] >= LESS_DETOUR and by[0][0] - straight < LESS_DETOUR:
                self._ask("way", [anchor.noun], kind, by[0][1])
            two = self.rng.sample([each for each in single if each is not anchor], 2)
            apart = [self._apart(each, anchor) for each in two]
            if abs(apart[0] - apart[1]) >= NEARER:
                nearer = two[0] if apart[0] < apart[1] else two[1]
                self._ask("among", [anchor.noun, two[0].noun, two[1].noun], kind, self._id(nearer))

    def _apart(self, one: Board, other: Board) -> float:
        return math.hypot(one.x - other.x, self.width * (one.row - other.row))

    def _from_here(self, board: Board) -> float:
        return math.hypot(board.x - self._here, self.width / 2)


def drawn(seed: int, worlds: int, ways: str = "ways") -> dict[str, Any]:
    """Return worlds with their wishes; the same for the same seed."""
    rng = random.Random(seed)
    return {"worlds": {f"drawn {at}": World(rng, WORDS[ways]).draw() for at in range(worlds)}}


def main() -> None:
    """Print one line a kind of question and a language."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--worlds", type=int, default=60)
    parser.add_argument("--ways", choices=("other", "third"), help="other ways of asking")
    parser.add_argument("--misses", action="store_true", help="show every miss")
    parser.add_argument("--write", type=Path, metavar="FILE", help="write the worlds instead")
    given = parser.parse_args()
    ways = f"{given.ways} ways" if given.ways else "ways"
    write_or_score(drawn(given.seed, given.worlds, ways), given.write, given.misses)


if __name__ == "__main__":
    main()
