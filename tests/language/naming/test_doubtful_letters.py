"""What may be wrong in a reading lies where the reader was unsure, and not in the letters that it read well."""

import pytest

from lpslam.language.model import Reading, Slots
from lpslam.language.naming.channel import evidence_of, log_likelihood, slip_of
from lpslam.language.naming.posterior import log_odds_against
from lpslam.language.offline import embedded_model


def slots(text: str, sure: dict[int, float]) -> Slots:
    """Every letter 0.999 sure but some."""
    return tuple(((letter, sure.get(at, 0.999)),) for at, letter in enumerate(text))


def reading(text: str, sure: dict[int, float], right: float = 0.4) -> Reading:
    return Reading(text, 3, 0.9, right, 1.0, slots(text, sure))


def test_letters_that_were_read_well_are_surer_than_the_others_and_all_together_as_sure_as_the_reading() -> None:
    (seen,) = evidence_of([reading("vornet", {5: 0.5})])
    costs = [slip_of(seen, at) for at in range(6)]
    assert min(costs[:5]) > slip_of(seen) > costs[5]
    assert sum(seen.doubts) == pytest.approx(1.0)
    assert slip_of(seen, before=5) < slip_of(seen, before=2), "what is missing is missing beside the doubtful letter"


def test_a_reading_speaks_against_another_string_by_the_letters_in_which_it_differs() -> None:
    seen = evidence_of([reading("vornet", {5: 0.5})])
    assert log_likelihood("vornem", seen, str) > log_likelihood("mornet", seen, str) + 2.0


def test_readings_that_doubt_their_tail_alone_agree_on_the_head() -> None:
    tails = "bcdfghj"
    doubtful = evidence_of([reading(f"vorne{tail}", {5: 0.4}, 0.3) for tail in tails])
    even = evidence_of([Reading(f"vorne{tail}", 3, 0.9, 0.3, 1.0) for tail in tails])
    assert log_odds_against("vorne", doubtful, str) < log_odds_against("vorne", even, str)


def test_a_name_of_which_the_last_letter_is_doubtful_and_contradicted_is_less_sure() -> None:
    namer = embedded_model()
    said = (("vornet du r", 8, 0.41, 4.3), ("vornet du l", 4, 0.24, 1.3), ("vornet du k", 3, 0.14, 1.3))
    told, evenly = (
        namer.name([Reading(text, count, 0.9, right, looks, own(text)) for text, count, right, looks in said])
        for own in (lambda text: slots(text, {10: 0.45}), lambda text: ())
    )
    assert told.name == evenly.name == "vornet du r"
    assert told.confidence < evenly.confidence - 0.05


def test_a_letter_that_the_reader_held_for_possible_looks_alike() -> None:
    """Computer is read as Comouter and Comauter; p was thought of in both, and m in neither."""

    def slots(read: str, other: float) -> Slots:
        return tuple(((each, 0.72), ("p", other)) if at == 3 else ((each, 0.99),) for at, each in enumerate(read))

    readings = [
        Reading("Comouter", 3, 0.96, 0.61, 2.3, slots("Comouter", 0.05)),
        Reading("Comauter", 3, 0.96, 0.56, 1.8, slots("Comauter", 0.03)),
    ]
    assert embedded_model().name(readings).name == "Computer"
