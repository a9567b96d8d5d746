"""The form of a wish: JSON and words."""

import pytest

from lpslam.language.offline import OfflineModel
from lpslam.language.wishes.form import PREVIOUS, Ask, Relation, Sort, Which, Wish

QUESTIONS = (
    "the toilet nearest to the exit",
    "First the pharmacy, then somewhere to eat near it",
    "gate B31",
    "Was liegt zwischen der Bank und der Bäckerei?",
    "离出口最近的厕所",
    "On my way from the bank to the exit, is there a café?",
    "Which is nearer to the exit: the bank or the café?",
)


@pytest.fixture(scope="module")
def model() -> OfflineModel:
    return OfflineModel()


@pytest.mark.parametrize("question", QUESTIONS)
def test_a_wish_is_the_same_after_json(model: OfflineModel, question: str) -> None:
    wish = model.read_wish(question)
    assert Wish.from_document(wish.to_document()) == wish


@pytest.mark.parametrize("tree", [{}, {"stops": 3}, {"stops": [{}]}, {"stops": [{"what": "a", "which": "best"}]}])
def test_what_is_no_wish_is_refused(tree: dict[str, object]) -> None:
    with pytest.raises(ValueError, match=r"no wish|not a valid"):
        Wish.from_document(tree)


def test_anchors_of_anchors_end() -> None:
    stop: dict[str, object] = {"what": "a"}
    for _ in range(10):
        stop = {"what": "a", "relation": "near", "anchor": [stop]}
    with pytest.raises(ValueError, match="no wish"):
        Wish.from_document({"stops": [stop]})


@pytest.mark.parametrize(
    ("question", "relation", "which", "anchor"),
    [
        ("the toilet nearest to the exit", Relation.NEAR, Which.NEAREST, "the exit"),
        ("a café next to the bank", Relation.NEXT_TO, Which.ANY, "the bank"),
        ("Was befindet sich links von der Bank?", Relation.LEFT_OF, Which.ANY, "der Bank"),
        ("¿Qué hay enfrente de la farmacia?", Relation.OPPOSITE, Which.ANY, "la farmacia"),
        ("un café près de la sortie", Relation.NEAR, Which.ANY, "sortie"),
        ("药店旁边的咖啡馆", Relation.NEXT_TO, Which.ANY, "药店"),
        ("薬局の向かいのカフェ", Relation.OPPOSITE, Which.ANY, "薬局"),
        ("출구에서 가장 가까운 화장실", Relation.NEAR, Which.NEAREST, "출구"),
        ("the café farthest from the exit", Relation.NEAR, Which.FARTHEST, "the exit"),
    ],
)
def test_relations_are_read(model: OfflineModel, question: str, relation: Relation, which: Which, anchor: str) -> None:
    (stop,) = model.read_wish(question).stops
    assert (stop.relation, stop.which, [each.what for each in stop.anchor]) == (relation, which, [anchor])


@pytest.mark.parametrize(
    ("question", "ask"),
    [
        ("How far is the exit?", Ask.HOW_FAR),
        ("list all restaurants", Ask.LIST),
        ("what is here?", Ask.HERE),
        ("这里有哪些餐厅", Ask.LIST),
        ("Was ist hier verboten?", Ask.FORBIDDEN),
        ("Is there a pharmacy?", Ask.IS_THERE),
    ],
)
def test_what_is_asked_is_read(model: OfflineModel, question: str, ask: Ask) -> None:
    assert model.read_wish(question).stops[0].ask is ask


@pytest.mark.parametrize(
    "question",
    [
        "I'd like pasta",
        "Is there a bookshop, by any chance?",
        "커피를 사러 가고 싶어요",
        "I waited all day and want a coffee",
    ],
)
def test_words_that_only_look_like_relations_are_none(model: OfflineModel, question: str) -> None:
    (stop,) = model.read_wish(question).stops
    assert stop.relation in (None, Relation.NEAR)
    assert stop.whole


def test_it_is_the_stop_before(model: OfflineModel) -> None:
    first, second = model.read_wish("First the pharmacy, then a café near it").stops
    assert second.anchor == (PREVIOUS,)
    assert first.relation is None


def test_persons_are_identities(model: OfflineModel) -> None:
    (stop,) = model.read_wish("Dr. Schneider's office").stops
    assert [(each.sort, each.value) for each in stop.identity] == [(Sort.PERSON, "Schneider")]


def test_a_wish_is_told_in_a_line(model: OfflineModel) -> None:
    assert str(model.read_wish("the toilet nearest to gate B31")) == (
        "“the toilet”, nearest, near (“gate B31”, must be gate b31)"
    )


def test_alternatives_that_are_named_are_told(model: OfflineModel) -> None:
    wish = model.read_wish("Which is nearer to the exit: the bank or the café?")
    assert str(wish) == "one of (“the bank” or “the café”), nearest, near (“the exit”), asks: which"
