"""A map as plain files: trajectories in TUM format, landmarks as JSON, points as PLY."""

import json
import os
import tempfile
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lpslam._version import __version__
from lpslam.errors import UserError
from lpslam.mapfile.point_cloud import write_ply
from lpslam.text.correcting.corrections import Correction, Corrections, Kind
from lpslam.text.types import Landmark, LandmarkLine

if TYPE_CHECKING:
    from lpslam.mapfile.language_map import LanguageMap

_FRAME = "camera optical frame (x right, y down, z forward) in the map frame (z up), metres"


def export_map(world: "LanguageMap", folder: Path) -> list[Path]:
    """Write trajectory.txt, keyframes.txt, landmarks.json and cloud.ply.

    Returns:
        The files written.

    Raises:
        UserError: the folder cannot be written.
    """
    return write_whole(folder, {name: partial(write, world) for name, write in _FILES.items()})


def write_whole(folder: Path, writers: Mapping[str, Callable[[Path], object]]) -> list[Path]:
    """Write files of a folder, which is made: all of them, or none.

    Args:
        folder: where to.
        writers: by file name; each writes to the path that it is given.

    Returns:
        The files.

    Raises:
        UserError: the folder cannot be written.
    """
    unfinished, is_new = "", not folder.exists()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        # Beside their places, so that a disk that fills leaves the old files and no part of new ones.
        with tempfile.TemporaryDirectory(prefix=".lpslam-", dir=folder) as unfinished:
            for name, write in writers.items():
                write(Path(unfinished) / name)
            for name in writers:
                os.replace(Path(unfinished) / name, folder / name)
    except OSError as error:
        raise UserError(f"{folder} cannot be written ({error.strerror}); choose another folder") from error
    except UserError as error:
        # The place that was asked for, and not where the file was until it is whole.
        raise UserError(str(error).replace(unfinished, str(folder))) from error
    finally:
        if is_new:
            with suppress(OSError):
                folder.rmdir()  # as long as nothing is in it
    return [folder / name for name in writers]


def _write_landmarks(world: "LanguageMap", path: Path) -> None:
    listed = {
        "format": "lpslam landmarks",
        "version": 1,
        "lpslam_version": __version__,
        "frame": "map: the first camera's place, z up",
        "units": {"position": "m", "spread": "m", "width": "m", "height": "m", "confidence": "0 to 1"},
        "landmarks": [landmark_record(mark) for mark in world.landmarks()],
    }
    path.write_text(json.dumps(listed, ensure_ascii=False, indent=1) + "\n", encoding="utf-8")


def _write_cloud(world: "LanguageMap", path: Path) -> None:
    """What keyframes saw, in its colours; the map's points where nothing was kept."""
    points, colours = world.coloured_cloud()
    write_ply(path, *((points, colours) if len(points) else (world.cloud(), None)))


_FILES: dict[str, Callable[["LanguageMap", Path], None]] = {
    "trajectory.txt": lambda world, path: world.frame_poses().to_tum_file(path, [f"every tracked frame: {_FRAME}"]),
    "keyframes.txt": lambda world, path: world.keyframe_poses().to_tum_file(path, [f"keyframes: {_FRAME}"]),
    "landmarks.json": _write_landmarks,
    "cloud.ply": _write_cloud,
}


def landmark_record(mark: Landmark) -> dict[str, Any]:
    """One landmark as JSON can hold it; metres, map frame."""
    return {
        "id": mark.id,
        "name": mark.name,
        "role": mark.role,
        "lines": [_line_record(line) for line in mark.lines],
        "variants": dict(mark.variants),
        "position": [round(float(value), 4) for value in mark.position],
        "normal": [round(float(value), 4) for value in mark.normal],
        "spread": round(mark.spread, 4),
        "width": round(mark.width, 4),
        "height": round(mark.height, 4),
        "observations": mark.observations,
        "confidence": round(mark.confidence, 4),
        "is_landmark": mark.is_landmark,
        "judgements": [asdict(judgement) for judgement in mark.judgements.values()],
        "corrections": [correction_record(each) for each in mark.corrections],
    }


def correction_record(said: Correction) -> dict[str, Any]:
    """What a person has said of a landmark, as JSON can hold it."""
    record: dict[str, Any] = {
        "number": said.number,
        "kind": said.kind.value,
        "landmark": said.landmark.id,
        "read": said.landmark.name,
        "made": said.made,
    }
    if said.kind is Kind.RENAME:
        record["name"] = said.name
    elif said.kind is Kind.JUDGE:
        record |= {"answer": said.answer, "question": said.question}
    elif said.into is not None:
        record |= {"into": said.into.id, "into_name": said.into.name}
    return record


def corrections_record(said: Corrections) -> dict[str, Any]:
    """All that a person has said of a map, and of which revision that is."""
    return {"revision": said.revision, "corrections": [correction_record(each) for each in said.entries]}


def _line_record(line: LandmarkLine) -> dict[str, Any]:
    return {
        "text": line.text,
        "role": line.role,
        "confidence": round(line.confidence, 4),
        "position": [round(float(value), 4) for value in line.position],
        "width": round(line.width, 4),
        "height": round(line.height, 4),
        "observations": line.observations,
    }
