"""How sure a name is by many poor readings: those that lie around one spelling agree on it, and strangers do not."""

import random

import pytest

from lpslam.language.model import Reading
from lpslam.language.offline import embedded_model

LETTERS = "abcdefghiklmnoprstuvwxyz"


def off_in_its_own_way(text: str, slips: int, rng: random.Random) -> str:
    letters = list(text)
    for at in rng.sample([at for at, ch in enumerate(letters) if ch.isalnum()], slips):
        letters[at] = rng.choice(LETTERS)
    return "".join(letters)


def poor_views(painted: str, count: int, slips: int, seed: int) -> list[Reading]:
    rng = random.Random(seed)
    return [Reading(off_in_its_own_way(painted, slips, rng), 1, 0.75, 0.1, 1.0) for _ in range(count)]


@pytest.mark.parametrize("painted", ["vornby kelwat", "do not lean", "mellowick taper", "grand street"])
@pytest.mark.parametrize("seed", range(3))
def test_poor_views_around_one_spelling_do_not_make_it_unsure(painted: str, seed: int) -> None:
    model = embedded_model()
    read = [Reading(painted, 3, 0.95, 0.6, 1.5)]
    alone = model.name(read)
    among = model.name(read + poor_views(painted, 30, 3, seed))
    assert among.name == alone.name == painted
    assert among.confidence > 0.7


def test_confidence_rises_with_views_that_agree() -> None:
    model = embedded_model()
    painted = "vornby kelwat"
    sure = []
    for count in (1, 3, 8):
        agreeing = [Reading(painted, count, 0.9, 0.4, float(count))]
        sure.append(model.name(agreeing + poor_views(painted, 10, 3, 1)).confidence)
    assert sure == sorted(sure)
    assert sure[-1] > 0.85


@pytest.mark.parametrize("seed", range(5))
def test_poor_views_without_a_middle_stay_unsure(seed: int) -> None:
    rng = random.Random(seed)
    strangers = ["".join(rng.choices(LETTERS, k=7)) for _ in range(20)]
    assert embedded_model().name([Reading(text, 1, 0.75, 0.1, 1.0) for text in strangers]).confidence < 0.5
