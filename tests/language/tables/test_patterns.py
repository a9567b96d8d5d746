"""Patterns that are kept: what they find is what patterns made by `re` find, and a spoilt cache does no harm."""

import re
from pathlib import Path

import pytest

from lpslam.language.tables import patterns
from lpslam.language.wishes.rules import rules_of

TEXTS = ("Which is the SECOND shop from the entrance?", "not the one by the lift, please", "gate B31, then a café")


@pytest.fixture(autouse=True)
def own_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A cache of this test, and no pattern that is ready."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(patterns, "_made", {})
    patterns.ready.cache_clear()
    return tmp_path


def found(pattern: re.Pattern[str]) -> list[tuple[object, ...]]:
    """What a pattern finds in the texts: where, and by which names."""
    hits = (pattern.search(text) for text in TEXTS)
    return [(hit.span(), hit.groupdict()) for hit in hits if hit is not None]


def test_kept_patterns_find_what_others_find() -> None:
    every = [(row.when, flags) for row in rules_of("en").rows for flags in (0, re.IGNORECASE)]
    for _ in range(2):  # made, then from the cache
        patterns.keep_ready("test", every)
        assert all((text, int(flags)) in patterns._made for text, flags in every)
        for text, flags in every:
            kept, plain = patterns.ready(text, flags), re.compile(text, flags)
            assert (kept.pattern, kept.flags, kept.groups, dict(kept.groupindex)) == (
                *(plain.pattern, plain.flags, plain.groups),
                dict(plain.groupindex),
            )
            assert found(kept) == found(plain)
        patterns.ready.cache_clear()
        patterns._made.clear()


def test_what_the_engine_does_not_take_is_made_anew() -> None:
    patterns._made[("a+b", 0)] = (0, b"\1\0\0\0", 0, {}, (None,))
    assert patterns.ready("a+b").search("xaab") is not None


def test_without_a_cache_patterns_are_made(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> None:
        raise ValueError

    monkeypatch.setattr(patterns, "kept", fail)
    patterns.keep_ready("test", [("a+b", 0)])
    assert patterns.ready("a+b").search("xaab") is not None


def test_patterns_of_modules_are_kept_together_and_made_ready_when_one_is_looked_for(own_cache: Path) -> None:
    texts = ("B[0-9]+", "c(?P<end>a.é)")
    for _ in range(2):  # made, then from the cache
        held = [patterns.standing(text, re.IGNORECASE) for text in texts]
        assert not any((text, int(re.IGNORECASE)) in patterns._made for text in texts)
        assert found(held[0]) == found(re.compile(texts[0], re.IGNORECASE))
        assert all((text, int(re.IGNORECASE)) in patterns._made for text in texts)
        assert found(held[1]) == found(re.compile(texts[1], re.IGNORECASE)) != []
        patterns.ready.cache_clear()
        patterns._made.clear()
    assert len(list((own_cache / "lpslam" / "made").glob("patterns-own-*"))) == 1
