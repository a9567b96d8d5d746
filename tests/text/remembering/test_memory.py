import pytest
from hypothesis import given
from hypothesis import strategies as st

from lpslam.config import MemoryConfig
from lpslam.text.remembering.memory import LongShortTermMemory, Pool

CONFIG = MemoryConfig()


def sight(memory: LongShortTermMemory, text: str, timestamp: float, confidence: float = 0.95) -> None:
    memory.forget(timestamp)
    memory.sight(text, confidence, timestamp)


@pytest.mark.parametrize("interval", [0.17, 0.25, 0.5])
def test_three_sightings_promote(interval: float) -> None:
    memory = LongShortTermMemory(CONFIG)
    for number in range(3):
        sight(memory, "HUAWEI", number * interval)
        assert len(memory.long_term) == (number == 2)
    assert memory.long_term[0].promoted_at == pytest.approx(2 * interval)
    assert not memory.short_term


def test_a_misreading_that_comes_twice_is_forgotten() -> None:
    memory = LongShortTermMemory(CONFIG)
    sight(memory, "PNIGHT", 0.0, 0.99)
    sight(memory, "PNIGHT", 0.2, 0.99)
    memory.forget(5.0)
    assert 0 in memory.short_term
    memory.forget(12.0)
    assert not memory.classes
    assert memory.forgotten_count == 1
    assert memory.forgotten[0].name == "PNIGHT"
    assert memory.forgotten[0].history[-1] == (12.0, 0.0)


@pytest.mark.parametrize("comes_again", [True, False])
def test_what_is_read_again_in_its_place_after_it_was_forgotten_was_seen_twice(comes_again: bool) -> None:
    memory = LongShortTermMemory(CONFIG)
    sight(memory, "SHOE LAB", 0.0)
    memory.forget(60.0)
    assert not memory.classes
    memory.sight("SHOE LAB", 0.95, 60.0, comes_again=comes_again)
    assert bool(memory.long_term) is comes_again
    memory.sight("SH0E", 0.6, 60.0, comes_again=True)
    assert len(memory.long_term) == comes_again, "two unsure readings are no text"


def test_an_identifier_is_never_used_again() -> None:
    memory = LongShortTermMemory(CONFIG)
    sight(memory, "PNIGHT", 0.0)
    memory.forget(100.0)
    sight(memory, "GUCCI", 100.0)
    assert [each.id for each in memory.classes] == [1]


def test_long_term_memory_fades_but_stays() -> None:
    memory = LongShortTermMemory(CONFIG)
    for number in range(5):
        sight(memory, "GUCCI", 0.2 * number)
    memory.forget(1e6)
    assert memory.long_term[0].score == 0.0
    assert memory.long_term[0].pool is Pool.LONG_TERM
    sight(memory, "GUCC1", 1e6)
    assert memory.long_term[0].count == 6


def test_homologous_texts_strengthen_one_class() -> None:
    memory = LongShortTermMemory(CONFIG)
    for number, text in enumerate(["Alienware", "Allenware", "Aiienware", "ALIENWARE"]):
        sight(memory, text, 0.2 * number)
    (text_class,) = memory.long_term.values()
    assert set(text_class.variants) == {"Alienware", "Allenware", "Aiienware", "ALIENWARE"}


def test_one_picture_counts_once() -> None:
    memory = LongShortTermMemory(CONFIG)
    for _ in range(10):
        sight(memory, "EXIT", 1.0)
    assert memory.short_term[0].score == pytest.approx(0.95)
    assert memory.short_term[0].count == 10


@pytest.mark.parametrize("fps", [10.0, 30.0, 60.0])
def test_what_is_remembered_does_not_depend_on_the_frame_rate(fps: float) -> None:
    memory = LongShortTermMemory(CONFIG)
    for frame in range(int(10 * fps) + 1):
        memory.forget(frame / fps)
        if frame % int(fps / 2) == 0 and frame <= 2 * fps:
            memory.sight("GUCCI", 0.9, frame / fps)
    # The first look, and four that are apart and say the same.
    seen = 0.9 * (1 + 4 * CONFIG.independent_weight)
    assert memory.long_term[0].score == pytest.approx(min(seen, CONFIG.ceiling) - 30 * CONFIG.forgetting * 10.0)


def test_reading_every_frame_promotes_no_sooner_than_looking() -> None:
    memory = LongShortTermMemory(CONFIG)
    for frame in range(30):
        sight(memory, "GUCCI", frame / 30.0)
        if memory.long_term:
            break
    assert 0.15 <= memory.clock <= 0.5  # type: ignore[operator]


@given(st.lists(st.tuples(st.sampled_from(["KFC", "GUCCI", "星巴克", "KFG"]), st.floats(0, 1), st.floats(0, 2))))
def test_scores_stay_in_bounds_and_history_is_in_order(events: list[tuple[str, float, float]]) -> None:
    config = MemoryConfig(history=16)
    memory, clock = LongShortTermMemory(config), 0.0
    for text, confidence, pause in events:
        clock += pause
        sight(memory, text, clock, confidence)
        for text_class in memory.classes:
            assert 0.0 <= text_class.score <= config.ceiling
            assert len(text_class.history) <= config.history
            times = [timestamp for timestamp, _ in text_class.history]
            assert times == sorted(times)
    assert all(each.score > 0.0 or each.last_seen == clock for each in memory.short_term.values())


def test_two_looks_that_are_apart_and_say_the_same_are_enough() -> None:
    memory = LongShortTermMemory(CONFIG)
    sight(memory, "HUAWEI", 0.0, 0.99)
    assert not memory.long_term
    sight(memory, "HUAWEI", 0.5, 0.99)
    assert memory.long_term[0].name == "HUAWEI"


@pytest.mark.parametrize(
    ("second", "interval", "confidence"),
    [("HUAWE1", 0.5, 0.99), ("HUAWEI", 0.2, 0.99), ("HUAWEI", 0.5, 0.9)],
    ids=["it says otherwise", "it is the same look", "it is not sure"],
)
def test_two_looks_are_not_enough(second: str, interval: float, confidence: float) -> None:
    memory = LongShortTermMemory(CONFIG)
    sight(memory, "HUAWEI", 0.0, confidence)
    sight(memory, second, interval, confidence)
    assert not memory.long_term


def test_what_was_read_twice_but_for_its_spaces_was_read_again() -> None:
    memory = LongShortTermMemory(MemoryConfig())
    for index, text in enumerate(["HAMMER &LADDER", "HAMMER & LADDER", "G LADDER", "GLADDER", "LADDER"]):
        known = memory.sight(text, 0.9, 0.2 * index, here={0})
    assert sorted(each.replace(" ", "") for each in known.read_again) == ["GLADDER", "HAMMER&LADDER"]


def test_looks_that_are_read_out_of_their_order_are_as_far_apart_as_they_were() -> None:
    config = MemoryConfig()
    step = config.full_sighting_interval

    def score(*times: float) -> float:
        memory = LongShortTermMemory(config)
        memory.forget(max(times))
        return [memory.sight("VELMO", 0.9, each) for each in times][-1].score

    late, beside = 10.0, 10.0 - step / 10.0
    assert score(late, late - step) == pytest.approx(score(late - step, late))
    assert score(late, late - step, late - step - step / 10.0) < score(late, late - step, late - 2 * step)
    assert score(late, beside) == pytest.approx(score(beside, late))
