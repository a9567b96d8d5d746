"""Questions one after the other: what follows keeps the want, what was named is left out."""

from dataclasses import dataclass, field
from typing import Any, cast

import numpy as np
import pytest

from lpslam.errors import UserError
from lpslam.language.offline import OfflineModel
from lpslam.language.questions.phrasing import answer_language, follow_up, phrases_in
from lpslam.mapfile.language_map import LanguageMap
from lpslam.navigation.known import known_of
from lpslam.poses import StampedPoses
from lpslam.text.types import Landmark
from lpslam.views.answers import answer_record
from lpslam.views.dialogue import Dialogue, parsed_place

LANGUAGES = ("en", "zh", "zh-Hant", "ja", "ko", "es", "de", "fr")


@dataclass
class World:
    """Signs at places; the camera was last at the origin, looking along x."""

    signs: list[tuple[str, float, float]]
    marks: list[Landmark] = field(init=False)

    def __post_init__(self) -> None:
        self.marks = [
            Landmark(1000 * at, name, {name: 3}, np.array([x, y, 1.0]), np.array([1.0, 0, 0]), 0.01, 1.0, 0.3, 3, 0.9)
            for at, (name, x, y) in enumerate(self.signs, 1)
        ]

    def landmarks(self) -> list[Landmark]:
        return self.marks

    def frame_poses(self) -> StampedPoses:
        pose = np.eye(4)
        pose[:3, :3] = [[0, 0, 1], [-1, 0, 0], [0, -1, 0]]
        pose[2, 3] = 1.0
        return StampedPoses(np.zeros(1), pose[None])


MALL = [
    ("Pizza Hut", 4.0, 0.0),
    ("KFC", 0.0, 6.0),
    ("Starbucks Coffee", -5.0, 0.0),
    ("Starbucks Coffee", 0.0, -2.0),
    ("新华书店", 3.0, 3.0),
    ("洗手间", 8.0, -8.0),
]


def dialogue(signs: list[tuple[str, float, float]] | None = None, **place: Any) -> Dialogue:
    return Dialogue(known_of(cast(LanguageMap, World(MALL if signs is None else signs))), OfflineModel(), **place)


def names(talk: Dialogue, *texts: str) -> list[str | None]:
    answers = [talk.ask(text) for text in texts]
    return [answer.landmark.name if answer.landmark is not None else None for answer in answers]


@pytest.mark.parametrize(
    ("language", "want", "more"),
    [
        ("en", "I am hungry", "and another one?"),
        ("en", "Where can I eat?", "is there anywhere else?"),
        ("zh", "我饿了", "还有别的吗？"),
        ("zh-Hant", "我想吃飯", "還有別的嗎？"),
        ("ja", "お腹が空いた", "他にありますか？"),
        ("ko", "배고파요", "다른 곳은 없나요?"),
        ("es", "Tengo hambre", "¿y otro más?"),
        ("de", "Ich habe Hunger", "und noch eins?"),
        ("fr", "J'ai faim", "et un autre ?"),
    ],
)
def test_another_one_keeps_the_want_and_leaves_out_what_was_named(language: str, want: str, more: str) -> None:
    talk = dialogue()
    first = talk.ask(want)
    assert first.landmark is not None
    assert talk.said(first) == talk.said(first)
    second = talk.ask(more)
    assert second.landmark is not None
    assert {first.landmark.name, second.landmark.name} == {"Pizza Hut", "KFC"}
    assert first.landmark not in second.alternatives
    pattern = phrases_in(language).say("because", why="")
    assert pattern.strip() in talk.said(second)
    for _ in range(4):
        last = talk.ask(more)
    assert last.landmark is None
    assert talk.said(last).startswith(phrases_in(language).say("no_further"))


def test_a_new_question_is_one_of_its_own_and_a_refusal_belongs_to_the_last() -> None:
    talk = dialogue()
    assert names(talk, "Where can I eat pizza?", "Where can I buy books?", "another?") == [
        "Pizza Hut",
        "新华书店",
        None,
    ]
    talk = dialogue()
    assert names(talk, "I am hungry", "but not pizza", "where is the toilet?", "but not pizza") [1:3] == [
        "KFC",
        "洗手间",
    ]  # fmt: skip


def test_another_without_a_question_before_it_is_no_follow_up() -> None:
    assert follow_up("another one?", None).question == "another one?"
    assert follow_up("I would like another coffee, please", "Where is the toilet?").question.startswith("I would")


def test_of_one_name_the_nearest_comes_first_and_then_the_next() -> None:
    talk = dialogue()
    first, second = talk.ask("Where can I get a coffee?"), talk.ask("another one?")
    assert first.landmark is not None
    assert second.landmark is not None
    assert (first.landmark.id, second.landmark.id) == (4000, 3000)
    assert first.same_name == 2
    assert "the nearest of 2 of this name" in dialogue_text("Where can I get a coffee?")


def dialogue_text(question: str, **place: Any) -> str:
    talk = dialogue(**place)
    return talk.said(talk.ask(question))


def test_several_doors_that_are_closed_are_each_a_line_of_the_answer() -> None:
    signs = [("Café Luna", 1.0, 0.0), ("Staff only", 3.0, 0.0), ("No entry", 5.0, 0.0)]
    talk = dialogue(signs)
    text = talk.said(talk.ask("Which doors is the public not allowed through?"))
    lines = [line for line in text.splitlines() if line.startswith("- ")]
    assert len(lines) == 2
    assert not any("Luna" in line for line in lines)


def test_distance_and_direction_are_from_where_the_robot_is() -> None:
    assert "4.0 m away, ahead" in dialogue_text("Where can I eat pizza?")
    position, heading = parsed_place("4,2,0")
    assert "2.0 m away, to the right" in dialogue_text("Where can I eat pizza?", position=position, heading=heading)
    position, heading = parsed_place("4,-2,-90")
    assert "2.0 m away, behind" in dialogue_text("Where can I eat pizza?", position=position, heading=heading)
    position, heading = parsed_place("0,0")
    assert heading is None
    assert "at 45° in the map" in dialogue_text("Where can I buy books?", position=position, heading=heading)
    record = answer_record(dialogue(position=position, heading=heading).ask("Where can I buy books?"))
    assert (record["direction"], record["direction_is_from"]) == (45.0, "map x axis")


@pytest.mark.parametrize("place", ["", "1", "1,2,3,4", "a,b", "nan,1", "inf,0", "1e300,0", "1;2"])
def test_a_place_that_is_none_is_one_line(place: str) -> None:
    with pytest.raises(UserError, match="X,Y,HEADING") as told:
        parsed_place(place)
    assert "\n" not in str(told.value)


@pytest.mark.parametrize("language", LANGUAGES)
def test_every_language_says_everything_and_directions_go_round(language: str) -> None:
    english, own = phrases_in("en"), phrases_in(language)
    assert own.language == language
    said = ("name", "x", "y", "z", "distance", "direction", "count", "why", "sure", "model", "others", "things")
    parts = dict.fromkeys((*said, "words", "wanted", "sign", "degrees"), "#")
    for what in english._templates:
        if what not in ("directions", "joint", "words"):
            assert own.say(what, **parts).count("#") >= min(1, english.say(what, **parts).count("#")), what
    assert len({own.direction(degrees) for degrees in range(0, 360, 45)}) == 8
    assert own.direction(359.0) == own.direction(0.0)


@pytest.mark.parametrize(
    ("question", "language"),
    [
        ("哪里可以买书？", "zh"), ("哪裡可以買書？", "zh-Hant"), ("我想吃飯", "zh-Hant"), ("本を買いたい", "ja"),
        ("책을 사고 싶어요", "ko"), ("¿Dónde puedo comer?", "es"), ("Wo kann ich essen?", "de"),
        ("Où puis-je manger ?", "fr"), ("Where can I eat?", "en"), ("", "en"), ("ᚠᚢᚦ", "en"),
    ],
)  # fmt: skip
def test_the_language_of_the_answer_is_the_questions(question: str, language: str) -> None:
    assert answer_language(question) == language


def test_signs_are_shown_without_what_steers_a_terminal_and_braces_stay() -> None:
    talk = dialogue([("[red]Pizza\x1b[2J\u202e", 1.0, 0.0)])
    said = talk.said(talk.ask("Where can I eat pizza?"))
    assert said.startswith("[red]Pizza")
    assert not {"\x1b", "\u202e"} & set(said)
    assert phrases_in("en").say("no_brand", name="{0} {why}") == "{0} {why} is not on this map"


def test_a_map_without_text_says_so() -> None:
    talk = dialogue([])
    assert "the map has no text" in talk.said(talk.ask("Where can I eat pizza?"))
    assert "地图上没有" in talk.said(talk.ask("哪里可以吃披萨？"))


def test_a_brand_is_called_as_the_asker_calls_it_and_found_by_its_nickname() -> None:
    assert "Starbucks is not on this map" in dialogue_of([("KFC", 1.0, 0.0)], "Where is Starbucks?")
    assert "スタバはこの地図にありません" in dialogue_of([("KFC", 1.0, 0.0)], "スタバはどこですか？")
    assert names(dialogue(), "スタバに行きたい") == ["Starbucks Coffee"]
    assert names(dialogue([("McDonald's", 1.0, 0.0), ("KFC", 2.0, 0.0)]), "is there a mcdonalds here") == ["McDonald's"]


def dialogue_of(signs: list[tuple[str, float, float]], question: str) -> str:
    talk = dialogue(signs)
    return talk.said(talk.ask(question))
