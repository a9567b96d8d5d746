import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from lpslam.slam.medians import medians_of_groups


@given(st.lists(st.tuples(st.integers(0, 4), st.floats(-1e6, 1e6)), min_size=1, max_size=60))
def test_medians_of_groups_are_those_of_each(rows: list[tuple[int, float]]) -> None:
    kinds, groups = np.unique([kind for kind, _ in rows], return_inverse=True)
    values = np.array([value for _, value in rows])
    medians = medians_of_groups(values, groups.astype(np.int64))
    assert medians.tolist() == [np.median(values[groups == kind]) for kind in range(len(kinds))]
