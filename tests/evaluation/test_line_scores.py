import pytest

from lpslam.evaluation.reading import LineScore, score_lines


def test_counts_by_hand() -> None:
    lines = ["NO PARKING", "Car Parks", "愚园路", "EXIT"]
    # One reading a line: "Car Parks!!" takes it from "CarPark", and "QXZT" is half of "EXIT".
    score = score_lines(["no parking", "CarPark", "愚路", "&%", "QXZT", "Car Parks!!"], lines)
    assert score.lines == 4
    assert score.found == 4
    assert score.read == 2
    assert score.exact == 1
    assert (score.letters, score.texts) == (9 + 8 + 3 + 4, 6)
    assert score.unread == ("愚园路", "EXIT")
    assert score.spurious == 1


def test_a_line_that_stands_there_twice_must_be_read_twice() -> None:
    twice = ["NO PARKING", "NO PARKING"]
    assert score_lines(["NO PARKING"], twice).exact == 1
    assert score_lines(["NO PARKING", "NO PARKING"], twice).exact == 2


@pytest.mark.parametrize(("texts", "lines"), [([], ["EXIT"]), (["EXIT"], []), ([], [])])
def test_nothing_read_or_to_read(texts: list[str], lines: list[str]) -> None:
    score = score_lines(texts, lines)
    assert (score.found, score.read, score.exact) == (0, 0, 0)
    assert score.spurious == len(texts)
    assert score.wrong_letters == score.letters


def test_scores_of_photographs_add_up() -> None:
    first, second = score_lines(["EXIT"], ["EXIT"]), score_lines(["TAXY"], ["TAXI", "ATM"])
    total = first + second
    assert total == LineScore(3, 2, 1, 1, 11, 4, 2, 0, ("TAXI", "ATM"))
    assert sum([first, second], LineScore()) == total
