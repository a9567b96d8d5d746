"""Which place a name stands for."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from lpslam.simulation.worlds.places.corridors import corridor, shop_fronts
from lpslam.simulation.worlds.places.homes import desk, living_room
from lpslam.simulation.worlds.places.lobbies import glass, office, people
from lpslam.simulation.worlds.places.malls import mall
from lpslam.simulation.worlds.places.outdoors import forecourt
from lpslam.simulation.worlds.places.place import Place
from lpslam.simulation.worlds.places.workshop import spotlit

_BUILDERS: dict[str, Callable[[np.random.Generator], Place]] = {
    "mall": mall,
    "desk": desk,
    "living": living_room,
    "corridor": corridor,
    "shop-fronts": shop_fronts,
    "glass": glass,
    "people": people,
    "lights-off": office,
    "forecourt": forecourt,
}


def build_place(name: str, seed: int, light: str) -> Place:
    """Build the place of a seed; `light` of "spots" leaves it in twilight with a few hot spots."""
    place = _BUILDERS[name](np.random.default_rng([seed, 105]))
    if light == "spots":
        low, high = place.solids.bounds
        place = replace(place, scene=spotlit(place.scene, np.random.default_rng([seed, 106]), np.array([low, high])))
    return place
