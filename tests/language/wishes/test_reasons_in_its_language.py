"""Why an answer is given is said in the language of the question."""

import pytest

from lpslam.language.languages import LANGUAGES
from lpslam.language.model import Candidate
from lpslam.language.offline import OfflineModel
from lpslam.language.questions.phrasing import phrases_in
from lpslam.language.tables.lexicon import read_table

MODEL = OfflineModel()
BOARDS = ("Gate A1", "Gate A2", "Meeting Room Everest", "Toilets")


def why(question: str) -> str:
    scorer = MODEL.scorer([Candidate(at, name) for at, name in enumerate(BOARDS)])
    return scorer.serve(MODEL.read_wish(question).stops[0]).evidence


@pytest.mark.parametrize(
    ("question", "said"),
    [
        ("gate A2", "the board bears it"),
        ("Wo ist Flugsteig A2?", "das steht auf dem Schild"),
        ("¿Dónde está la puerta A7?", "ningún letrero lleva gate a7"),
        ("où est Everest ?", "le panneau porte ce nom"),
    ],
)
def test_a_reason_is_in_the_language_of_the_question(question: str, said: str) -> None:
    assert why(question) == said


@pytest.mark.parametrize("language", [*LANGUAGES, "zh-Hant"])
def test_every_language_has_every_reason(language: str) -> None:
    reasons = read_table("reasons.json")
    assert language == "en" or reasons[language].keys() == reasons["de"].keys()
    assert phrases_in(language).reason("no such reason") == "no such reason"
