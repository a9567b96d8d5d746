"""One question, read for maps whose names say different things of it."""

import subprocess
import sys

import pytest

from lpslam.language.questions.question import read_question
from lpslam.language.questions.speaking import languages_of
from lpslam.language.tables.knowledge import load_knowledge
from lpslam.language.tables.lexicon import Meaning
from lpslam.language.tables.words import PhraseTable


def _named(*names: str) -> PhraseTable[Meaning]:
    return PhraseTable((name, Meaning("name", ((name, 1.0),))) for name in names)


def test_one_question_means_what_the_names_of_each_map_say() -> None:
    knowledge = load_knowledge()
    asked = "where is the blue cup, please?"
    assert read_question(asked, knowledge).wanted_names == ()
    assert read_question(asked, knowledge, _named("blue cup")).wanted_names == ("blue cup",)
    assert read_question(asked, knowledge, _named("red door")).wanted_names == ()


def test_a_question_means_the_same_in_every_process() -> None:
    # Two kinds of shelf within one phrase once came in the order of a set, which differs from process to process.
    asked = "Ich hab noch nichts gefrühstückt, gibt's hier ein belegtes Brötchen?"
    code = (
        "from lpslam.language.questions.question import read_question\n"
        "from lpslam.language.tables.knowledge import load_knowledge\n"
        f"print(read_question({asked!r}, load_knowledge()).wanted)"
    )
    said = {
        subprocess.run(
            [sys.executable, "-c", code], env={"PYTHONHASHSEED": str(seed)}, capture_output=True, text=True, check=True
        ).stdout
        for seed in (1, 5)
    }
    assert len(said) == 1


@pytest.mark.parametrize("name", ["Nadia's Bakery", "Tomas’s Books"])
def test_a_name_with_a_possessive_is_english(name: str) -> None:
    assert languages_of(name, load_knowledge())[0] == "en"
