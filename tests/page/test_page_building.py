"""The page of a map: one file, whatever signs say is text in it, and nothing is asked of anybody else."""

import base64
import hashlib
import json
import re
import unicodedata
from html.parser import HTMLParser
from pathlib import Path

import pytest

from lpslam.config import PageConfig
from lpslam.errors import UserError
from lpslam.page.building import LANGUAGES, growing_page, page_of, policy, write_page
from lpslam.page.record import room_points
from lpslam.slam.state import EventKind, TrackingState
from small_maps import small_map, with_floor

HOSTILE = "</script><img src=x onerror=alert(1)>"


class Seen(HTMLParser):
    """The tags of a page, what its scripts and styles hold, and what of that the browser runs."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.held: list[tuple[str, str]] = []
        self.run: list[tuple[str, str]] = []
        self.is_run = False
        self.policy = ""
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.is_run = tag == "style" or (tag == "script" and "type" not in dict(attrs))
        if dict(attrs).get("http-equiv") == "Content-Security-Policy":
            self.policy = dict(attrs)["content"] or ""

    def handle_data(self, data: str) -> None:
        if self.tags and self.tags[-1] in ("script", "style") and data.strip():
            self.held.append((self.tags[-1], data))
            self.run += [(self.tags[-1], data)] if self.is_run else []


def data_of(page: str) -> dict[str, object]:
    (text,) = [held for tag, held in Seen(page).held if tag == "script" and held.startswith("{")]
    tree = json.loads(text)
    assert isinstance(tree, dict)
    return tree


def test_a_sign_that_is_markup_is_text() -> None:
    page = page_of(small_map(signs=("KFC", HOSTILE)), live=False)
    seen = Seen(page)
    assert "img" not in seen.tags
    # The data, the points and the program.
    assert seen.tags.count("script") == 3
    assert len(seen.run) == 2
    assert HOSTILE not in page
    names = [sign["name"] for sign in data_of(page)["signs"]]  # type: ignore[attr-defined]
    assert "KFC" in names
    assert any("onerror" in name for name in names)


UNSEEN = (
    "Pizza \u202eHut", "ATM\x00\x07", "a\u200bb\u2066c\u2069", "Bakery\nBrot\r\u2028x", "\ufeffKFC", "\x1b[31mred",
    "@data@ @script@", "{{sign}} ${sign} `x`", "\u0007",
)  # fmt: skip


def strings_of(tree: object) -> list[str]:
    """All strings of a tree, keys included."""
    if isinstance(tree, dict):
        return [each for pair in tree.items() for part in pair for each in strings_of(part)]
    if isinstance(tree, list):
        return [each for part in tree for each in strings_of(part)]
    return [tree] if isinstance(tree, str) else []


@pytest.mark.parametrize("live", [False, True])
def test_nothing_unseen_of_a_sign_comes_onto_the_page(live: bool) -> None:
    world = small_map(signs=UNSEEN, source="a\u202eb\x07")
    for each in world.text.memory.long_term.values():
        each.history = [(0.0, 0.0), (1.0, 3.0)]
    page = page_of(world, live=live)
    tree = data_of(page)
    said = [each for key in ("title", "signs", "memory", "edits", "question") for each in strings_of(tree[key])]
    assert not [each for each in said for char in each if unicodedata.category(char) in ("Cc", "Cf", "Co", "Cs", "Zl")]
    assert tree["title"] == "ab"
    names = {sign["name"] for sign in tree["signs"]}  # type: ignore[attr-defined]
    assert {"Pizza Hut", "ATM", "abc", "Bakery Brot x", "KFC", "@data@ @script@", "{{sign}} ${sign} `x`"} <= names
    # Marks of the page in a sign are words.
    assert page.count('"@data@ @script@"') >= 1
    assert Seen(page).tags.count("script") == 3


def test_the_policy_allows_the_pages_own_style_and_script_and_nothing_else() -> None:
    for live in (False, True):
        seen = Seen(page_of(small_map(), live=live))
        assert seen.policy == policy(live)
        rules = dict(rule.strip().split(" ", 1) for rule in seen.policy.split(";"))
        assert rules["default-src"] == "'none'"
        assert rules["img-src"] == "data:"
        assert rules.get("connect-src") == ("'self'" if live else None)
        for tag, held in seen.run:
            digest = base64.b64encode(hashlib.sha256(held.encode()).digest()).decode()
            assert rules[f"{tag}-src"] == f"'sha256-{digest}'"


def test_no_address_stands_in_the_page() -> None:
    page = page_of(with_floor(small_map()), live=True)
    assert not re.findall(r"https?://", page)
    assert "@import" not in page


def test_the_ground_is_a_picture_and_all_languages_have_all_words() -> None:
    data = data_of(page_of(with_floor(small_map()), live=False))
    picture = str(data["picture"])
    assert base64.b64decode(picture.removeprefix("data:image/png;base64,")).startswith(b"\x89PNG")
    words = data["words"]
    assert isinstance(words, dict)
    assert tuple(words) == LANGUAGES
    assert len({frozenset(each) for each in words.values()}) == 1
    assert data_of(page_of(small_map(), live=False))["picture"] == ""


def test_a_file_has_its_ground_and_points_within_it_and_a_server_gives_them_later() -> None:
    world = with_floor(small_map())
    alone, beside = page_of(world, live=False), page_of(world, live=True)
    ground = data_of(alone)["ground"]
    assert isinstance(ground, dict)
    # The camera stands 1.2 m over the floor, at the origin.
    assert abs(ground["height"] + 1.2) < 0.05
    left, bottom, right, top = ground["extent"]
    assert left < 3 < right
    assert bottom < 0 < top
    (points,) = [held for tag, held in Seen(alone).held if tag == "script" and not held.startswith(("{", '"'))]
    assert base64.b64decode(points) == room_points(world, PageConfig().file_points, PageConfig()).content()
    assert "ground" not in data_of(beside)
    assert not [held for tag, held in Seen(beside).held if tag == "script" and not held.startswith(("{", '"'))]


def test_a_file_that_cannot_be_written_is_said(tmp_path: Path) -> None:
    written = write_page(small_map(), tmp_path / "page.html")
    assert written.stat().st_size < 10_000_000
    with pytest.raises(UserError, match="cannot be written"):
        write_page(small_map(), tmp_path / "none" / "page.html")


def test_every_language_has_the_same_words_and_one_for_whatever_can_happen() -> None:
    words = data_of(growing_page("a walk"))["words"]
    assert isinstance(words, dict)
    for language in LANGUAGES:
        assert set(words[language]) == set(words["en"]), language
        assert set(words[language]["states"]) == {each.value for each in TrackingState}, language
        assert set(words[language]["events"]) == {each.value for each in EventKind}, language
