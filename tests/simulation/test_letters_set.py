import logging

import pytest

from lpslam.simulation import fonts


@pytest.mark.parametrize("has_kerning", [True, False])
def test_where_letters_are_set_otherwise_one_warning_says_so(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture, has_kerning: bool
) -> None:
    monkeypatch.setattr(fonts.features, "check", lambda feature: has_kerning)
    fonts.sign_font.cache_clear()
    fonts._warn_of_other_widths.cache_clear()
    with caplog.at_level(logging.WARNING):
        for size in (20.0, 30.0):
            fonts.sign_font("latin-serif", size)
    assert ["libfribidi0" in record.getMessage() for record in caplog.records] == [True] * (not has_kerning)
