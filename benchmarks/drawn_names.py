"""Score names, people and numbers in worlds that are drawn: what is right is beyond dispute by how they are made.

python benchmarks/drawn_names.py                          # 200 worlds of seed 0
python benchmarks/drawn_names.py --seed 7 --worlds 500 --misses
python benchmarks/drawn_names.py --write FILE.json        # the wishes as a set for `benchmarks/wishes.py`

A world has the boards of one language: numbered things of two to four kinds, shops of few trades, people and streets.
No two boards share a name, a number of one kind, or, but for the trade, a word. A question asks for one of them in one
of thirty ways of a language: as it stands there, without capitals or accents, by the part that is its own, with a slip,
by another title, with its number written otherwise, in the words of another language; or for one that is not there,
which nothing answers. With `--ranges` the numbered boards bear ranges in the plural (Rooms 2A–2F, Lockers 61–120), and
are asked by one number in them: in the singular, shortened, in another language; some are of things that no table
lists (Kojen 20–30). The words are in `benchmarks/language/drawn_names.json`.
"""

import argparse
import json
import random
import re
import unicodedata
from collections import Counter, defaultdict
from pathlib import Path
from typing import Any

import numpy as np

from lpslam.language.offline import OfflineModel
from lpslam.navigation.places import Here
from lpslam.navigation.solver import solve
from wishes import is_right, places_of

WORDS: dict[str, dict[str, Any]] = json.loads(
    (Path(__file__).parent / "language" / "drawn_names.json").read_text(encoding="utf-8")
)
LANGUAGES = tuple(WORDS["asked"])
UNSPACED = ("zh", "ja", "ko")
LIKE = (
    # Kinds of which one word may be said: a board of one may be meant by another.
    {"platform", "gate", "bay", "berth", "exit", "stop"},
    {"room", "ward", "screen", "hall", "box", "building"},
    {"stand", "stop", "zone", "box", "building", "counter", "court"},
    {"aisle", "lift", "car"},
)
FULL_WIDTH = str.maketrans("0123456789ABCDEFGHK", "０１２３４５６７８９ＡＢＣＤＥＦＧＨＫ")
LATIN_SHOP = {"en": "{own} {trade}", "de": "{trade} {own}", "fr": "{trade} {own}", "es": "{trade} {own}"}
SLIP = 6  # letters of a word in which a slip is made

FIRST = {"1": 1, "2": 10, "3": 101, "d": 101}  # the lowest number of a range, by its style
LENGTHS = (4, 6, 12)  # of ranges

Wish = dict[str, Any]


class World:
    """One world while it is drawn: its boards, and what is asked of it."""

    def __init__(self, rng: random.Random, has_ranges: bool = False) -> None:
        self.rng, self._has_ranges = rng, has_ranges
        self.language = rng.choice(LANGUAGES)
        self.boards: list[str] = []
        self.wishes: list[Wish] = []
        self._taken: list[str] = []

    def draw(self) -> dict[str, Any]:
        """Return the world as `benchmarks/wishes.py` has it."""
        kinds: list[str] = []
        for kind in self.rng.sample(sorted(WORDS["ranged" if self._has_ranges else "numbered"]), 4):
            if not any({kind, other} <= like for like in LIKE for other in kinds):
                kinds.append(kind)
        for kind in kinds[:2] if self._has_ranges else kinds:
            (self._ranged if self._has_ranges else self._numbered)(kind)
        if self._has_ranges:
            self._unheard()
        trades = self.rng.sample(WORDS["trades"][self.language], 3)
        for _ in range(7):
            self._shop(self.rng.choice(trades))
        for _ in range(4):
            self._person()
        self._street()
        self.rng.shuffle(self.boards)
        places = [{"name": name, "position": [4.0 * (at % 9), 5.0 * (at // 9)]} for at, name in enumerate(self.boards)]
        return {"places": places, "wishes": self.wishes}

    def _ask(self, kind: str, what: str, expected: str | None, language: str) -> None:
        asked = self.rng.choice(WORDS["asked"][language]).format(x=what)
        self.wishes.append({"question": asked, "expected": expected, "language": language, "category": kind})

    def _other_language(self) -> str:
        return self.rng.choice(LANGUAGES) if self.rng.random() < 0.25 else self.language

    def _numbered(self, kind: str) -> None:
        said, style = self.rng.choice(WORDS["numbered"][kind][self.language]), self.rng.choice(WORDS["codes"][kind])
        codes: dict[str, str] = {}
        while len(codes) < 5:
            code = self._code(style)
            codes.setdefault(code.casefold(), code)
        *present, absent = codes.values()
        self.boards += [said.format(n=code) for code in present]
        for code in self.rng.sample(present, 2):
            language = self._other_language()
            in_words = said if language == self.language else self.rng.choice(WORDS["numbered"][kind][language])
            asked = in_words.format(n=self._written(code, language))
            kind_of = "number" if language == self.language else "number, another language"
            self._ask(kind_of, asked.lower() if self.rng.random() < 0.3 else asked, said.format(n=code), language)
        self._ask("number, absent", said.format(n=absent), None, self.language)

    def _ranged(self, kind: str) -> None:
        """Three boards of one kind with a range each, and what is asked of the numbers in them."""
        said, spans = self.rng.choice(WORDS["ranged"][kind][self.language]), self._spans(WORDS["ranges"][kind])
        self.boards += [said.format(n=f"{span[0]}–{span[-1]}") for span in spans[:3]]
        for span in spans[:2]:
            board, code = said.format(n=f"{span[0]}–{span[-1]}"), self.rng.choice(span)
            other = self._other_language()
            one = self.rng.choice(WORDS["numbered"][kind][other])
            self._ask(
                "range" if other == self.language else "range, another language", one.format(n=code), board, other
            )
            for short in WORDS["short"].get(kind, {}).get(self.language, [])[:1]:
                self._ask("range, shortened", short.format(n=self.rng.choice(span)), board, self.language)
        one = self.rng.choice(WORDS["numbered"][kind][self.language])
        self._ask("range, absent", one.format(n=self.rng.choice(spans[3])), None, self.language)

    def _unheard(self) -> None:
        """Ranges of what no table lists, high enough that no other board holds them."""
        word, many = self.rng.choice(WORDS["unheard"][self.language])
        first = self.rng.randrange(500, 900)
        for at in (first, first + 20):
            board, code = f"{many} {at}–{at + 19}", self.rng.randrange(at, at + 20)
            self.boards.append(board)
            self._ask("range, unheard of", f"{word} {code}", board, self.language)
        self._ask("range, absent", f"{word} {first + 50}", None, self.language)

    def _spans(self, styles: list[str]) -> list[list[str]]:
        """Four ranges of one style, code by code, that share none."""
        style, size = self.rng.choice(styles), self.rng.choice(LENGTHS)
        if style == "L":
            return [list("ABCDEFGHIJKLMNOP"[4 * at : 4 * at + 4]) for at in range(4)]
        if style == "1L":
            return [[f"{at}{letter}" for letter in "ABCDEF"] for at in range(2, 6)]
        if style.startswith("L"):
            first = FIRST[style[1]]
            return [[f"{letter}{first + at}" for at in range(size)] for letter in self.rng.sample("ABCDEFGH", 4)]
        if style == "d":
            return [[f"{floor}.{at:02}" for at in range(1, size + 1)] for floor in range(1, 5)]
        return [[str(FIRST[style] + size * each + at) for at in range(size)] for each in range(4)]

    def _code(self, style: str) -> str:
        letter, digits = self.rng.choice("ABCDEFGHK"), {"1": (1, 12), "2": (10, 60), "3": (101, 420)}
        number = next((str(self.rng.randint(*digits[each])) for each in style if each in digits), "")
        return (
            f"{number}{letter}" if style[:1].isdigit() and "L" in style else f"{letter if 'L' in style else ''}{number}"
        )

    def _written(self, code: str, language: str) -> str:
        """A code as it is written otherwise, now and then."""
        way = self.rng.random()
        if way < 0.1 and language in UNSPACED:
            return code.translate(FULL_WIDTH)
        if way < 0.3:
            return re.sub(r"(?<=[A-Z])(?=\d)", self.rng.choice(" -"), code)
        return code

    def _own(self, words: list[str]) -> str | None:
        """A word that no board of the world has, nor one like it."""
        for word in self.rng.sample(words, len(words)):
            bare = _bare(word)
            if all(_differ(bare, other) for other in self._taken):
                self._taken.append(bare)
                return word
        return None

    def _shop(self, trade: str) -> None:
        own = self._own(WORDS["own" if self.language in UNSPACED else "people"][self.language])
        if own is None:
            return
        shape = LATIN_SHOP.get(self.language, "{own}{trade}" if self.language != "ko" else "{own} {trade}")
        name = shape.format(own=own, trade=trade)
        if self.rng.random() < 0.15 and self.language not in UNSPACED:
            self._ask("name, absent", name, None, self.language)
            return
        self.boards.append(name)
        if self.rng.random() < 0.6:
            language = self._other_language()
            asked = self.rng.choice([name, name.lower(), _bare(name), own, self._with_slip(name)])
            self._ask("name" if language == self.language else "name, another language", asked, name, language)

    def _with_slip(self, name: str) -> str:
        words = name.split()
        long = [at for at, word in enumerate(words) if len(word) >= SLIP and word.isascii() and word.isalpha()]
        if long:
            at, word = long[-1], words[long[-1]]
            cut = self.rng.randrange(2, len(word) - 1)
            words[at] = self.rng.choice([word[:cut] + word[cut + 1 :], word[:cut] + word[cut] + word[cut:]])
        return " ".join(words)

    def _person(self) -> None:
        surname = self._own(WORDS["people"][self.language])
        if surname is None:
            return
        is_here = self.rng.random() < 0.7
        board = self.rng.choice(WORDS["titles"][self.language]).format(s=surname)
        asked = self.rng.choice(WORDS["asked titles"][self.language]).format(s=surname)
        self.boards += [board] if is_here else []
        kind = "person" if is_here else "person, absent"
        self._ask(kind, asked, board if is_here else None, self._other_language() if is_here else self.language)

    def _street(self) -> None:
        word = self._own(WORDS["street names" if self.language in UNSPACED else "people"][self.language])
        if word is not None:
            name = self.rng.choice(WORDS["streets"][self.language]).format(w=word)
            self.boards.append(name)
            self._ask("name", self.rng.choice([name, name.lower()]), name, self.language)


def _bare(text: str) -> str:
    """Without capitals and the accents of Latin letters."""
    plain = "".join(ch for ch in unicodedata.normalize("NFD", text.lower()) if not unicodedata.combining(ch))
    return plain if plain.isascii() else text.lower()


def _differ(word: str, other: str) -> bool:
    """Whether two words are so far apart that a slip of one is no slip of the other."""
    if not word.isascii() or not other.isascii():
        return not set(word) & set(other)
    return not (word[:3] == other[:3] or word in other or other in word or word[-4:] == other[-4:])


def drawn(seed: int, worlds: int, has_ranges: bool = False) -> dict[str, Any]:
    """Return worlds with their wishes; the same for the same seed."""
    rng = random.Random(seed)
    return {"worlds": {f"drawn {at}": World(rng, has_ranges).draw() for at in range(worlds)}}


def score(worlds: dict[str, Any], shows_misses: bool = False) -> dict[str, Counter[str]]:
    """Return by kind and by language how many wishes are right, wrong and not answered."""
    model = OfflineModel()
    counts: dict[str, Counter[str]] = defaultdict(Counter)
    for world in worlds.values():
        places, candidates = places_of(world)
        scorer = model.scorer(candidates)
        for wish in world["wishes"]:
            here = None if "here" not in world else np.array([*world["here"], 0.0])
            solution = solve(model.read_wish(wish["question"]), places, scorer, Here(here))
            found = [stop.place.name for stop in solution.stops if stop.place is not None]
            result = "right" if is_right(wish, solution) else "wrong" if found else "none"
            for key in (wish["category"], f"language {wish['language']}"):
                counts[key][result] += 1
            if shows_misses and result != "right":
                print(f"{result}: {wish['question']!r}: {found}, not {wish['expected']!r}")
    return counts


def main() -> None:
    """Print one line a kind of question and a language."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--worlds", type=int, default=200)
    parser.add_argument("--ranges", action="store_true", help="boards bear ranges")
    parser.add_argument("--misses", action="store_true", help="show every miss")
    parser.add_argument("--write", type=Path, metavar="FILE", help="write the worlds instead")
    given = parser.parse_args()
    write_or_score(drawn(given.seed, given.worlds, given.ranges), given.write, given.misses)


def write_or_score(tree: dict[str, Any], path: Path | None, shows_misses: bool) -> None:
    """Write drawn worlds where a file is named; else print one line a kind of question and a language."""
    if path is not None:
        path.write_text(json.dumps(tree, ensure_ascii=False, indent=1), encoding="utf-8")
        return
    for key, count in sorted(score(tree["worlds"], shows_misses).items()):
        print(
            f"{key}: {count['right']} of {count.total()} = {count['right'] / count.total():.1%}, wrong {count['wrong']}"
        )


if __name__ == "__main__":
    main()
