"""Asking aloud: offered only where the browser hears on this machine itself."""

from pathlib import Path
from typing import Any

import pytest

from in_chromium import until
from lpslam.page.building import write_page
from small_maps import small_map

pytestmark = pytest.mark.slow

_HEARING = """
window.heard = [];
window.SpeechRecognition = class {
  static async available(options) { return options.processLocally && ANSWER; }
  start() {
    window.heard.push([this.lang, this.processLocally]);
    this.onresult({ results: [[{ transcript: "kfc" }]] });
    this.onend();
  }
};
"""


def opened(browser: Any, folder: Path, answer: str) -> Any:
    """The page in a browser that says so of hearing on the machine."""
    page = browser.new_context(locale="de-DE").new_page()
    page.add_init_script(_HEARING.replace("ANSWER", answer))
    page.goto(write_page(small_map(signs=("KFC", "SHOES")), folder / "page.html").as_uri())
    return page


def test_what_is_said_is_asked(browser: Any, tmp_path: Path) -> None:
    page = opened(browser, tmp_path, '"available"')
    until(page, "!document.getElementById('speak').hidden")
    assert page.locator("#speak").get_attribute("aria-label") == "Laut fragen"
    page.locator("#speak").click()
    until(page, "lpslamPage.chosen() === 0")
    assert page.evaluate("window.heard") == [["de-DE", True]]
    assert page.locator("#log .question").last.inner_text() == "kfc"
    assert page.locator("#speak").get_attribute("aria-pressed") == "false"


@pytest.mark.parametrize("answer", ['"downloadable"', '"unavailable"', "(() => { throw new Error('no'); })()"])
def test_where_speech_would_leave_the_machine_it_is_not_offered(browser: Any, tmp_path: Path, answer: str) -> None:
    page = opened(browser, tmp_path, answer)
    page.wait_for_timeout(300)
    assert page.locator("#speak").is_hidden()
