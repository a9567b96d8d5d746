"""Signs stuffed with words that everybody asks for: how many of 150 answers one such sign changes.

python benchmarks/stuffed_signs.py --misses

Each of fifteen signs is put into ten of the development worlds, at the place where the asker stands; every wish that
is answered rightly without it must be answered alike with it.
"""

import argparse
import itertools
import json
from typing import Any

import numpy as np

from lpslam.language.model import Candidate
from lpslam.language.offline import OfflineModel
from lpslam.language.wishes.form import Which
from lpslam.navigation.places import Here, Place
from lpslam.navigation.solution import Solution
from lpslam.navigation.solver import solve
from wishes import DEVELOPMENT, is_right, places_of

STUFFED = (
    "coffee pizza wc shoes bank",
    "toilet restaurant pharmacy shop exit",
    "food drinks clothes phone doctor",
    "咖啡 厕所 药店 银行 鞋店",
    "カフェ トイレ 薬局 銀行 靴",
    "커피 화장실 약국 은행 신발",
    "café baño farmacia banco zapatos",
    "Kaffee WC Apotheke Bank Schuhe",
    "café toilettes pharmacie banque chaussures",
    "milk bread meat fish fruit cheese wine",
    "cardiology emergency maternity radiology pharmacy",
    "gate platform check-in security baggage taxi",
    "library cafeteria office lecture hall lab",
    "receiving shipping packing returns canteen",
    "reception pool gym bar spa restaurant",
)
ANSWERS = 150


def is_plain(model: OfflineModel, question: str) -> bool:
    """Whether a wish is one stop that says nothing of where it stands, nor which of several."""
    (first, *more) = model.read_wish(question).stops
    return not more and first.relation is None and first.which is Which.ANY


def main() -> None:
    """Print how many answers one stuffed sign changes."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--misses", action="store_true", help="show every answer that is changed")
    given = parser.parse_args()
    model = OfflineModel()
    worlds = list(json.loads(DEVELOPMENT.read_text(encoding="utf-8"))["worlds"].values())[:10]
    asked = changed = 0
    wants: dict[int, list[Any]] = {}
    for at, (world, sign) in enumerate(itertools.product(worlds, STUFFED)):
        places, candidates = places_of(world)
        here = Here(np.array([*world.get("here", (0.0, 0.0)), 0.0][:3], dtype=float))
        assert here.position is not None
        stuffed = Place(len(places), sign, here.position + 0.5)

        def answer(question: str, marks: list[Place], shown: list[Candidate], here: Here = here) -> Solution:
            return solve(model.read_wish(question), marks, model.scorer(shown), here)

        if id(world) not in wants:
            # A wish that no relation or distance decides: what stands nearer is nearer, whatever it says.
            plain_ones = [case for case in world["wishes"] if is_plain(model, case["question"])]
            wants[id(world)] = [
                case for case in plain_ones if is_right(case, answer(case["question"], places, candidates))
            ]
        case = wants[id(world)][at % len(wants[id(world)])]
        plain = answer(case["question"], places, candidates).stops[-1].place
        more = answer(case["question"], [*places, stuffed], [*candidates, Candidate(stuffed.id, sign)]).stops[-1].place
        asked += 1
        if (more and more.id) != (plain and plain.id):
            changed += 1
            if given.misses:
                print(f"{case['question']!r}: {more and more.name!r}, not {plain and plain.name!r}")
    assert asked == ANSWERS
    print(f"{changed} of {asked} answers changed by a stuffed sign")


if __name__ == "__main__":
    main()
