"""The fit of how sure a landmark's lines are finds what made them, and leaves out what it is compared on."""

from pathlib import Path

import numpy as np
import pytest

from lpslam.text.boards.lines import as_measured

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"


@pytest.fixture(autouse=True)
def _beside_the_benchmarks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(BENCHMARKS))


def lines(even: float, growth: float, seed: int = 0, count: int = 20000) -> list[tuple[float, bool]]:
    """Lines that are right as often as these coefficients say, stated by those of the program."""
    rng = np.random.default_rng(seed)
    told = rng.normal(1.5, 1.5, count)
    right = rng.random(count) < 1.0 / (1.0 + np.exp(-even - growth * told))
    return [(as_measured(1.0 / (1.0 + np.exp(-odds))), bool(one)) for odds, one in zip(told, right, strict=True)]


def test_the_coefficients_are_found_again() -> None:
    from text_certainty import fit

    assert fit(lines(-0.5, 1.2)) == pytest.approx((-0.5, 1.2), abs=0.05)
    assert fit(lines(0.8, 0.4)) == pytest.approx((0.8, 0.4), abs=0.05)
    with pytest.raises(ValueError, match="no lines"):
        fit([])


def test_a_recording_is_compared_by_what_the_others_say(capsys: pytest.CaptureFixture[str]) -> None:
    from text_certainty import compare

    # The two of one place agree with each other only, and are not fitted to each other.
    compare({"hall": lines(-1.5, 0.6, 1), "hall-night": lines(-1.5, 0.6, 2), "street": lines(0.37, 0.66, 3)})
    hall, night, _ = capsys.readouterr().out.splitlines()
    for said in (hall, night):
        as_stated, left_out = (float(said.split(word)[1].split()[0]) for word in ("error", "stated,"))
        assert as_stated > 0.2
        assert left_out == pytest.approx(as_stated, abs=0.02)
