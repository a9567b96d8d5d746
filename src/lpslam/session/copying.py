"""A map as it is now, which what comes later does not change."""

from contextlib import AbstractContextManager
from dataclasses import replace
from typing import Any

from lpslam.mapfile.language_map import LanguageMap
from lpslam.slam.map import SlamMap
from lpslam.slam.trajectory import Trajectory
from lpslam.text.placing.instances import KeyframePoses
from lpslam.text.text_map import TextMap


def copied(world: LanguageMap) -> LanguageMap:
    """A map that shares nothing that changes with another one; call it with that one's locks held."""
    slam = SlamMap.from_arrays(world.slam.to_arrays())
    slam.settle()
    text = TextMap.from_document(world.text.to_document())
    text.corrections = world.text.corrections
    return replace(
        world,
        slam=slam,
        trajectory=Trajectory.from_arrays(world.trajectory.to_arrays()),
        text=text,
        events=list(world.events),
        scans=None if world.scans is None else world.scans.copy(),
    )


def poses_now(text: TextMap, slam: SlamMap, stepping: AbstractContextManager[Any]) -> KeyframePoses:
    """Poses of the keyframes on which texts hang, at one moment; call it with the lock of the text map held.

    Args:
        text, slam: of the map.
        stepping: the lock of whatever changes `slam`; held no longer than poses are looked up.
    """
    keyframes = {seen.keyframe for each in text.long_term for seen in each.observations}
    with stepping, slam.lock:
        poses = {each: slam.world_from_keyframe(each) for each in keyframes if slam.is_home(each)}
    return poses.get
