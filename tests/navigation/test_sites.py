"""Where all places of a map stand is made once, and says the same as each place."""

import numpy as np

from lpslam.language.model import Candidate
from lpslam.language.offline import embedded_model
from lpslam.navigation.places import Here, Place
from lpslam.navigation.sites import Sites
from lpslam.navigation.solver import solve

ROWS = ((7, "KFC", 0.0), (3, "Bank", 4.0), (5, "KFC", 9.0))
PLACES = [Place(id_, name, np.array([x, 0.0, 0.0])) for id_, name, x in ROWS]


def test_columns_say_what_the_places_say() -> None:
    sites = Sites(PLACES)
    assert sites.by_id[3].name == "Bank"
    assert sites.rows(np.array([5, 4, 7])).tolist() == [2, -1, 0]
    assert sites.positions[:, 0].tolist() == [0.0, 4.0, 9.0]
    assert [place.id for place in sites.nearest(np.array([8.0, 0.0, 0.0]), 2)] == [5, 3]
    assert [place.id for place in sites.nearest(np.array([8.0, 0.0, 0.0]), 9)] == [5, 3, 7]
    assert sites.usual_gap == 4.0


def test_a_map_without_places_has_no_gap_and_no_rows() -> None:
    assert Sites([]).usual_gap == 0.0
    assert Sites([]).rows(np.array([1])).tolist() == [-1]


def test_what_is_made_once_answers_as_the_places_do() -> None:
    model, here = embedded_model(), Here(np.array([8.0, 0.0, 0.0]))
    scorer = model.scorer([Candidate(place.id, place.name) for place in PLACES])
    sites = Sites(PLACES)
    for question in ("Where is KFC?", "the KFC next to the bank", "KFC, not the nearest one"):
        solutions = [solve(model.read_wish(question), given, scorer, here) for given in (sites, PLACES)]
        one, other = ([stop.place for stop in solution.stops] for solution in solutions)
        assert one == other
    # Whoever asks elsewhere is told of what is nearest there.
    assert solve(model.read_wish("Where is KFC?"), sites, scorer, Here(np.zeros(3))).stops[0].place is PLACES[0]
