"""A person corrects a map on its page: two browsers at once, hostile names, and the file that keeps it all."""

import re
import signal
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from in_chromium import PATIENCE_S, need_chromium, shown, until
from lpslam.isolated import python_command
from lpslam.mapfile.language_map import LanguageMap
from small_maps import small_map, with_floor

pytestmark = pytest.mark.slow

CODE = "import sys; sys.argv = ['lpslam', *sys.argv[1:]]; from lpslam.__main__ import main; main()"
SIGNS = ("KFO", "Pizza Hut 必胜客", "Toilets", "KFC")
HOSTILE = "<img src=x onerror=alert(1)>"


@pytest.fixture
def viewed(tmp_path: Path) -> Iterator[tuple[Path, str]]:
    need_chromium()
    path = tmp_path / "mall.lpmap"
    with_floor(small_map(signs=SIGNS)).save(path)
    words = python_command(CODE, "view", str(path), "--port", "0", "--no-browser")
    with subprocess.Popen(words, stderr=subprocess.PIPE, text=True, cwd=tmp_path) as process:
        assert process.stderr is not None
        said = process.stderr.readline()
        found = re.search(r"http://[\d.:]+", said)
        assert found is not None, said
        yield path, found[0]
        process.send_signal(signal.SIGINT)


def names(path: Path) -> dict[int, str]:
    return {mark.id: mark.name for mark in LanguageMap.load(path).landmarks()}


def press(page: Any, sign: str, button: str) -> None:
    page.locator("#signs button", has_text=sign).first.click()
    page.locator("#card button", has_text=button).click()


def test_a_sign_is_renamed_merged_judged_and_hidden_and_all_is_taken_back(
    browser: Any, viewed: tuple[Path, str]
) -> None:
    path, url = viewed
    before = names(path)
    with shown(browser, url, own=url, locale="en-US") as page, shown(browser, url, own=url, locale="fr-FR") as other:
        press(page, "KFO", "Rename")
        page.fill("#card input", HOSTILE)
        page.keyboard.press("Enter")
        until(page, "document.querySelector('#by-hand summary').textContent.includes('(1)')")
        assert names(path)[0] == HOSTILE
        until(page, f"document.querySelector('#signs button').textContent === '{HOSTILE}'")
        assert page.locator("#card h2").inner_text() == HOSTILE
        assert page.locator("img").count() == 0
        # Whoever looks on sees it too.
        until(other, f"document.querySelector('#signs button').textContent === '{HOSTILE}'")

        press(page, "Toilets", "Hide")
        until(page, "document.querySelectorAll('#signs button').length === 3")
        press(page, "Pizza Hut", "no")
        until(page, "document.querySelector('#card [aria-pressed=true]')?.textContent === 'no'")
        press(page, HOSTILE, "Same as")
        page.locator("#card select").select_option("3000")
        page.locator("#card form button", has_text="Save").click()
        until(page, "document.querySelectorAll('#signs button').length === 2")
        assert LanguageMap.load(path).landmarks()[0].is_landmark is False
        assert names(path) == {1000: SIGNS[1], 3000: "KFC"}

        page.locator("#by-hand summary").click()
        for left in (3, 2, 1, 0):
            page.locator("#by-hand button").first.click()
            until(page, f"document.querySelectorAll('#by-hand li').length === {left}")
    assert names(path) == before


def test_who_is_quicker_than_the_server_is_no_second_editor(browser: Any, viewed: tuple[Path, str]) -> None:
    path, url = viewed
    with shown(browser, url, own=url, locale="en-US") as page:
        page.locator("#signs button", has_text="KFO").first.click()
        page.evaluate("""() => {
          for (const text of ["no", "Hide"]) {
            [...document.querySelectorAll("#card button")].find(each => each.textContent === text).click();
          }
        }""")
        until(page, "document.querySelectorAll('#by-hand li').length === 2")
        assert page.locator("#complaint").inner_text() == ""
    assert 0 not in names(path)


def test_what_is_written_on_a_card_outlasts_what_others_change(browser: Any, viewed: tuple[Path, str]) -> None:
    _, url = viewed
    with shown(browser, url, own=url, locale="en-US") as page, shown(browser, url, own=url, locale="en-US") as other:
        press(page, "KFO", "Rename")
        page.fill("#card input", "Kentucky")
        press(other, "Toilets", "Hide")
        until(page, "document.querySelectorAll('#signs button').length === 3")
        page.press("#card input", "Enter")
        until(page, "document.querySelector('#card h2').textContent === 'Kentucky'")


def test_of_two_editors_the_second_is_shown_what_there_is(browser: Any, viewed: tuple[Path, str]) -> None:
    path, url = viewed
    with (
        shown(browser, url, own=url, locale="en-US") as first,
        # The browser itself notes each refusal.
        shown(browser, url, own=url, locale="de-DE", troubles_are_meant=True) as second,
    ):
        # The second does not hear of what the first does.
        second.route("**/page/**", lambda route: route.abort())
        press(first, "KFO", "Rename")
        first.fill("#card input", "Kentucky")
        first.keyboard.press("Enter")
        until(first, "document.querySelector('#card h2').textContent === 'Kentucky'")
        second.unroute("**/page/**")
        press(second, "KFO", "Ausblenden")
        until(second, "document.getElementById('complaint').textContent.startsWith('Jemand anders')")
        until(second, "document.querySelector('#card h2').textContent === 'Kentucky'")
        assert names(path)[0] == "Kentucky"
        press(second, "Kentucky", "Ausblenden")
        until(second, "document.querySelectorAll('#signs button').length === 3")
    assert 0 not in names(path)


def test_and_another_one_means_what_was_asked_before(browser: Any, viewed: tuple[Path, str]) -> None:
    _, url = viewed
    with shown(browser, url, own=url, locale="en-US") as page:
        answers = []
        for number, question in enumerate(("Where is a restaurant?", "and another one?")):
            page.fill("#question", question)
            page.press("#question", "Enter")
            until(page, f"(document.querySelectorAll('#log .answer')[{number}]?.textContent ?? '…') !== '…'")
            answers.append(page.evaluate("lpslamPage.chosen()"))
        assert None not in answers, page.locator("#log").inner_text()
        assert answers[0] != answers[1]


def test_what_was_understood_is_opened_and_corrected(browser: Any, viewed: tuple[Path, str]) -> None:
    _, url = viewed
    with shown(browser, url, own=url, locale="en-US") as page:
        page.fill("#question", "Where is the nearest restaurant?")
        page.press("#question", "Enter")
        until(page, "lpslamPage.chosen() === 1000")
        until(page, "lpslamPage.way() > 1")
        assert page.evaluate("lpslamPage.goal()") is not None
        page.locator(".understood summary").click()
        assert "nearest" in page.locator(".understood").inner_text()
        # Another place is chosen, and the way leads there.
        page.locator(".understood .tools button", has_text="KFC").click()
        until(page, "lpslamPage.chosen() === 3000")
        until(page, "lpslamPage.goal() !== null")
        # Without the constraint the surest is named, in place of the first answer.
        page.get_by_label("Take out: which nearest").click()
        until(page, "document.querySelector('#log .answer').textContent.startsWith('KFC at')")
        assert page.locator("#log .answer").count() == 1
        assert page.get_by_label("Take out: which nearest").count() == 0
        # And another one is another of what was put right.
        page.fill("#question", "and another one?")
        page.press("#question", "Enter")
        until(page, "(document.querySelectorAll('#log .answer')[1]?.textContent ?? '…') !== '…'")
        assert page.evaluate("lpslamPage.chosen()") == 1000
        assert page.get_by_label("Take out: which nearest").count() == 0


def test_a_plan_is_shown_whole_with_its_stops_in_the_language_of_the_question(
    browser: Any, viewed: tuple[Path, str]
) -> None:
    _, url = viewed
    with shown(browser, url, own=url, locale="en-US") as page:
        page.fill("#question", "Zuerst zu Pizza Hut, dann zu KFC")
        page.press("#question", "Enter")
        until(page, "lpslamPage.stops().length === 2")
        until(page, "document.querySelector('#log .answer').textContent.includes('KFC ist vor Ihnen')")
        steps = page.locator("#log .answer").inner_text().splitlines()
        assert [line.split(":")[0] for line in steps if "ist vor Ihnen" in line] == ["1. Pizza Hut 必胜客", "2. KFC"]
        # When the view has come to rest, the panel hides none of the way, and neither does the rim.
        places = [page.evaluate("lpslamPage.goal()"), *page.evaluate("lpslamPage.stops()"), [4.0, 0.0], [12.0, 0.0]]
        inside = """places => { const { x, y, scale } = lpslamPage.view(); return places.every(([a, b]) => {
          const u = innerWidth / 2 + (a - x) * scale, v = innerHeight / 2 - (b - y) * scale;
          return u > 360 && u < innerWidth && v > 0 && v < innerHeight; }); }"""
        end = time.monotonic() + PATIENCE_S
        while not page.evaluate(inside, places):
            assert time.monotonic() < end, page.evaluate("lpslamPage.view()")
        # One place of its own leaves no numbers behind.
        page.locator("#signs button", has_text="Toilets").click()
        assert page.evaluate("lpslamPage.stops()") == []
