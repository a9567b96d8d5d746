"""The page in a real browser: asked, chosen, seen; skipped where there is none."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from in_chromium import shown, until
from lpslam.config import SightingConfig
from lpslam.mapfile.language_map import LanguageMap
from lpslam.page.building import write_page
from lpslam.text.sightings import Sighting, pictured
from small_maps import small_map, with_floor

pytestmark = pytest.mark.slow
SIGNS = ("KFC", "Pizza Hut 必胜客", "<b>BOLD</b>")


@pytest.fixture
def page(browser: Any, tmp_path: Path) -> Iterator[Any]:
    file = write_page(with_floor(small_map(signs=SIGNS)), tmp_path / "page.html")
    with shown(browser, file.as_uri()) as opened:
        yield opened


def test_it_opens_from_the_file_system_and_lists_the_signs(page: Any) -> None:
    assert page.locator("#signs button").all_inner_texts() == list(SIGNS)
    assert page.locator("#count").inner_text() == "3 Schilder"
    assert page.locator("b").count() == 0


def test_a_name_that_is_asked_for_is_chosen_and_flown_to(page: Any) -> None:
    before = page.evaluate("lpslamPage.view()")
    page.fill("#question", "必胜客")
    page.press("#question", "Enter")
    until(page, "lpslamPage.chosen() === 1000")
    until(page, f"lpslamPage.view().x !== {before['x']} || lpslamPage.view().y !== {before['y']}")
    assert page.locator("#card h2").inner_text() == "Pizza Hut 必胜客"
    page.fill("#question", "nothing like it")
    page.press("#question", "Enter")
    until(page, "lpslamPage.chosen() === null")
    assert page.locator("#log .answer").last.inner_text() == "Kein Schild sagt das."


def test_keys_move_the_map_and_show_all_of_it_again(page: Any) -> None:
    page.locator("#map").focus()
    whole = page.evaluate("lpslamPage.view()")
    page.keyboard.press("ArrowRight")
    page.keyboard.press("+")
    assert page.evaluate("lpslamPage.view()") != whole
    page.keyboard.press("0")
    assert page.evaluate("lpslamPage.view()") == whole


def test_the_memory_plot_tells_one_class_from_the_others(browser: Any, tmp_path: Path) -> None:
    world = small_map(signs=SIGNS)
    for number, each in world.text.memory.long_term.items():
        each.history = [(0.0, 0.0), (1.0 + 3 * number, 2.0 + 3 * number), (9.0, 1.0 + number)]
    with shown(browser, write_page(world, tmp_path / "page.html").as_uri(), locale="en-US") as page:
        page.locator("#memory-open").click()
        assert page.locator("#memory-name").inner_text() == "<b>BOLD</b> – at most 8.0, after 7.0 s, remembered"
        page.locator("#memory-plot").focus()
        page.keyboard.press("ArrowRight")
        assert page.locator("#memory-name").inner_text().startswith("Pizza Hut 必胜客 – at most 5.0")
        page.keyboard.press("Enter")
        assert page.evaluate("lpslamPage.chosen()") == 1000
        # The lowest line of all, near its end.
        box = page.locator("#memory-plot").bounding_box()
        page.mouse.move(box["x"] + box["width"] - 60, box["y"] + box["height"] - 45)
        assert page.evaluate("lpslamPage.remembered()") == 0
        page.mouse.click(box["x"] + box["width"] - 60, box["y"] + box["height"] - 45)
        assert page.evaluate("lpslamPage.chosen()") == 0
        page.locator("#memory-close").click()
        assert not page.locator("#memory").is_visible()


def test_a_dialogue_is_kept_as_it_goes_on(page: Any) -> None:
    for question in ("KFC", "no such thing", "必胜客"):
        page.fill("#question", question)
        page.press("#question", "Enter")
    assert page.locator("#log .question").all_inner_texts() == ["KFC", "no such thing", "必胜客"]
    assert page.locator("#log .answer").all_inner_texts() == ["KFC", "Kein Schild sagt das.", "Pizza Hut 必胜客"]


def with_a_picture(world: LanguageMap, high: int = 60) -> LanguageMap:
    """A map whose first sign was kept as a picture."""
    image = np.full((high, 160, 3), 90, np.uint8)
    box = np.array([[20, 10], [140, 10], [140, high - 10], [20, high - 10]], np.float64)
    jpeg = pictured(image, box, 10.0, SightingConfig())
    # The first board stands at the origin, a metre up.
    world.text.sightings.keep(0, Sighting(0, (0.0, -1.0, 0.0), 20.0, jpeg), lambda key: True)
    return world


def test_a_card_shows_how_its_sign_was_seen(browser: Any, tmp_path: Path) -> None:
    world = with_a_picture(small_map(signs=SIGNS))
    with shown(browser, write_page(world, tmp_path / "page.html").as_uri(), locale="en-US") as page:
        page.locator("#signs button").first.click()
        picture = page.locator("#card img")
        assert picture.get_attribute("alt") == "How it was seen: KFC (1/1)"
        until(page, "document.querySelector('#card img').naturalWidth > 100")
        page.locator("#signs button").nth(1).click()
        assert page.locator("#card img").count() == 0


def test_a_sign_that_means_harm_is_shown_and_found_as_words(browser: Any, tmp_path: Path) -> None:
    signs = (
        "<img src=x onerror=alert(1)>",
        "</script><script>alert(1)</script>",
        "Pizza \u202e\x07Hut",
        "javascript:alert(1)",
    )
    with shown(browser, write_page(small_map(signs=signs), tmp_path / "page.html").as_uri()) as page:
        page.on("dialog", lambda dialog: pytest.fail("a sign was run"))
        for number, sign in enumerate(("<img src=x onerror=alert(1)>", "</script><script>", "Pizza Hut", "javascript")):
            page.fill("#question", sign)
            page.press("#question", "Enter")
            until(page, f"lpslamPage.chosen() === {1000 * number}")
        page.locator("#in-space").click()
        page.wait_for_timeout(300)
        assert page.locator("img").count() == 0
        assert page.locator("script:not([type])").count() == 1
        assert page.locator("a").count() == 0
        told = page.evaluate("document.getElementById('panel').textContent + document.title")
        assert "Pizza Hut" in told
        assert not set("\u202e\x07") & set(told)


def test_on_paper_the_signs_are_below_the_map_and_no_buttons(page: Any) -> None:
    page.emulate_media(media="print")
    page.evaluate("dispatchEvent(new Event('beforeprint'))")
    drawn, panel = page.locator("#map").bounding_box(), page.locator("#panel").bounding_box()
    assert panel["y"] >= drawn["y"] + drawn["height"]
    assert panel["width"] == drawn["width"]
    for each in ("#modes", "#replay", "#question", "#go"):
        assert not page.locator(each).is_visible()
    assert page.locator("#signs button").last.is_visible()
    # The map is in the middle, and not beside a panel.
    middle = page.evaluate("lpslamPage.view()")["x"]
    page.evaluate("dispatchEvent(new Event('afterprint'))")
    assert page.evaluate("lpslamPage.view()")["x"] < middle
    page.locator("#signs button").first.click()
    assert page.locator("#card h2").is_visible()
    assert not page.locator("#card button").first.is_visible()


def test_everything_that_can_be_used_has_a_name(page: Any) -> None:
    nameless = page.evaluate("""
      [...document.querySelectorAll("button, input, canvas, nav, aside, section, [role]")].filter(
      each => !each.closest("[hidden]") && !["status", "alert"].includes(each.getAttribute("role")) &&
      !(each.getAttribute("aria-label") || each.textContent.trim())).map(each => each.outerHTML.slice(0, 80))""")
    assert nameless == []
    page.locator("#map").focus()
    page.keyboard.press("Tab")
    page.keyboard.press("Shift+Tab")
    assert page.evaluate("getComputedStyle(document.getElementById('map')).outlineStyle") == "solid"


def test_a_card_is_shut_and_leaves_the_list_in_sight(browser: Any, tmp_path: Path) -> None:
    """On a laptop: a long dialogue, a card with a large picture, and the signs below them."""
    file = write_page(with_a_picture(small_map(signs=SIGNS), high=160), tmp_path / "page.html")
    with shown(browser, file.as_uri(), viewport={"width": 1280, "height": 720}, locale="en-US") as page:
        for _ in range(8):
            page.fill("#question", SIGNS[0])
            page.press("#question", "Enter")
        until(page, "document.querySelector('#card img').naturalWidth > 100")
        page.fill("#question", "")
        row = page.locator("#signs button").first
        row.scroll_into_view_if_needed()
        at = row.bounding_box()
        assert at["y"] + at["height"] <= 720 - 16
        page.locator("#card").get_by_label("Close").click()
        until(page, "lpslamPage.chosen() === null")
        assert page.locator("#card h2").count() == 0


@pytest.mark.parametrize(("wide", "high"), [(390, 844), (768, 1024), (844, 390), (1280, 800)])
def test_the_panel_leaves_the_map_room_and_all_of_it_can_be_reached(
    browser: Any, tmp_path: Path, wide: int, high: int
) -> None:
    file = write_page(with_floor(small_map(signs=SIGNS)), tmp_path / "page.html")
    with shown(browser, file.as_uri(), viewport={"width": wide, "height": high}) as page:
        for each in (SIGNS[0], SIGNS[1], SIGNS[0]):
            page.fill("#question", each)
            page.press("#question", "Enter")
        panel = page.locator("#panel").bounding_box()
        assert panel["width"] <= (wide if wide <= 640 else max(0.36 * wide, 264))
        assert panel["height"] <= (high / 2 if wide <= 640 else high)
        assert page.evaluate("document.documentElement.scrollWidth") == wide
        # The last fact of the card, by scrolling alone, and inside of what is shown.
        last = page.locator("#card dd").last
        last.scroll_into_view_if_needed()
        at = last.bounding_box()
        assert panel["y"] <= at["y"] <= at["y"] + at["height"] <= panel["y"] + panel["height"] + 1
