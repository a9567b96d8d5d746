"""The paper's own examples (Table I, Fig. 14, Fig. 15), answered by the embedded model."""

from pathlib import Path

import pytest

from lpslam.errors import UserError
from lpslam.evaluation.language import LanguageCases, paper_cases, read_cases, score_language
from lpslam.language.offline import OfflineModel


def test_every_example_of_the_paper_is_right(model: OfflineModel) -> None:
    score = score_language(model, paper_cases())
    assert score.misses == ()
    assert str(score) == "naming 2/2, judging 12/12, choosing 3/3 (offline)"


def test_the_scorer_counts_misses(model: OfflineModel, tmp_path: Path) -> None:
    wrong = tmp_path / "wrong.json"
    wrong.write_text(
        '{"naming": [{"readings": [["KFC", 3, 0.9]], "expected": ["Pizza Hut"]}],'
        ' "judging": [{"question": "Is this a shop?", "expected": {"KFC": false, "DANGER": false}}],'
        ' "choosing": {"landmarks": ["KFC"], "questions": [{"question": "Where is the toilet?", "expected": "KFC"}]}}',
        encoding="utf-8",
    )
    score = score_language(model, read_cases(wrong))
    assert (score.naming, score.judging, score.choosing) == ((0, 1), (1, 2), (0, 1))
    assert len(score.misses) == 3


def test_an_empty_set_scores_nothing(model: OfflineModel) -> None:
    assert score_language(model, LanguageCases()).choosing == (0, 0)


@pytest.mark.parametrize("text", ["", "[]", '{"naming": [{}]}', '{"judging": 3}'])
def test_a_file_that_is_no_example_set_is_a_clear_error(tmp_path: Path, text: str) -> None:
    path = tmp_path / "cases.json"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(UserError, match=r"cases\.json"):
        read_cases(path)
    with pytest.raises(UserError, match="cannot be read"):
        read_cases(tmp_path / "none.json")
