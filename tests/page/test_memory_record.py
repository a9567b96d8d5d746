"""Histories of scores, as they are drawn: thinned without losing their peaks."""

import numpy as np

from lpslam.page.record import memory_record
from small_maps import small_map


def test_long_histories_are_thinned_to_their_highs_and_lows() -> None:
    world = small_map(signs=("KFC", "ATM"))
    rng = np.random.default_rng(3)
    scores = rng.uniform(1, 5, 5000)
    scores[1234], scores[4000] = 9.0, 0.25
    world.text.memory.long_term[0].history = [(float(at), float(score)) for at, score in enumerate(scores)]
    (record,) = [each for each in memory_record(world.text.memory)["histories"] if each["id"] == 0]
    assert len(record["samples"]) <= 122
    assert [1234.0, 9.0] in record["samples"]
    assert [4000.0, 0.25] in record["samples"]
    assert record["samples"] == sorted(record["samples"])
