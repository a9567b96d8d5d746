"""Two anchors of one place: who asks what is between them means two of which one place alone stands between."""

from collections.abc import Sequence

import numpy as np

from lpslam.language.wishes.served import Served
from lpslam.navigation.places import Place
from lpslam.navigation.relations import Scene


def likely_places(served: Served, scene: Scene) -> list[Place]:
    """Return the places that may serve, the likeliest first, however unsure."""
    by_id = scene.sites.by_id
    ids = (*sorted(served.scores, key=lambda id_: (-served.scores[id_], id_)), *served.others)
    return [by_id[id_] for id_ in dict.fromkeys(ids) if id_ in by_id][: scene.config.pair_likely]


def meant_pair(found: Sequence[Sequence[Place]], likely: Sequence[Sequence[Place]], scene: Scene) -> list[list[Place]]:
    """Return the places of two anchors, likelier ones where those that were found are not so.

    Args:
        found: the places of each anchor, as far as they are sure.
        likely: the places of each, sure or not, the likeliest first.
        scene: where they stand.

    Returns:
        What was found, where two of it have one place between them or no two of the likely ones have; else those two.
    """
    # Of many of a kind the two that are nearest are meant.
    if max(map(len, found)) > scene.config.pair_likely + 1 or _closest(found, scene) is not None:
        return [list(each) for each in found]
    pair = _closest(likely, scene)
    return [list(each) for each in found] if pair is None else [[place] for place in pair]


def _closest(anchors: Sequence[Sequence[Place]], scene: Scene) -> tuple[Place, Place] | None:
    """The likeliest two places, one of each anchor, that have one place between them."""
    ranked = sorted((i + j, i, j) for i in range(len(anchors[0])) for j in range(len(anchors[1])))
    pairs = ((anchors[0][i], anchors[1][j]) for _, i, j in ranked)
    return next((pair for pair in pairs if _is_close(*pair, scene)), None)


def _is_close(one: Place, two: Place, scene: Scene) -> bool:
    """Whether one place alone stands between two others, on the straight way."""
    apart = float(np.linalg.norm(one.position - two.position))
    to_one, to_two = (np.linalg.norm(scene.sites.positions - each.position, axis=1) for each in (one, two))
    is_on_the_way = (to_one + to_two <= (1.0 + scene.config.pair_detour) * apart) & (np.maximum(to_one, to_two) < apart)
    return one is not two and int(is_on_the_way.sum()) == 1
