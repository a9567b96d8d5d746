"""What is wrong with the options of a command, before anything is begun."""

from os.path import realpath
from pathlib import Path
from typing import Any

from lpslam.errors import UserError
from lpslam.whole_files import refuse_unwritable


def refuse_with_localize(
    output: Path | None, continued: Path | None, live: bool, view: bool, trajectory: Path | None
) -> None:
    """Localisation only reads a map, and its poses must go somewhere."""
    for given, option in ((output, "--output"), (continued, "--continue"), (live, "--live"), (view, "--view")):
        if given:
            raise UserError(f"--localize and {option} exclude each other: the map is only read")
    if trajectory is None:
        raise UserError("where should the poses go? give --trajectory OUT.txt with --localize")


def refuse_with_fronts(frames: int | None, world: int | None, factor: list[str] | None, given: dict[str, Any]) -> None:
    """A street of one's own boards is as long as they are, and has no floor plan and no words to choose."""
    others = {"frames": frames, "world": world, "factor": factor or None, **given}
    for name, value in others.items():
        if value is not None and name != "light":
            raise UserError(f"--fronts and --{name.replace('_', '-')} exclude each other")


def refuse_overwriting(output: Path | None, trajectory: Path | None, base: Path | None) -> None:
    """A map that is read is not written, no two results go to one file, and the poses can be written where they go."""
    if trajectory is not None:
        refuse_unwritable(trajectory)
    places = {"--output": output, "--trajectory": trajectory}
    for option, path in places.items():
        if path is not None and base is not None and realpath(path) == realpath(base):
            raise UserError(f"{option} {path} is the map that is read, which is not overwritten; choose another name")
    if output is not None and trajectory is not None and realpath(output) == realpath(trajectory):
        raise UserError(f"--output and --trajectory are both {output}; choose another name for one of them")


def refuse_old_map(output: Path, force: bool) -> None:
    """A map is hours of walking: another one takes its place only by `--force`."""
    if output.exists() and not force:
        raise UserError(f"{output} is a map already; choose another name, or give --force to replace it")


def config_of(path: Path | None, overrides: dict[str, Any] | None = None) -> Any:
    """The configuration of a file, or of options by section and name."""
    from lpslam.config import Config

    if path is not None:
        return Config.from_yaml(path)
    if not overrides:
        return Config()
    from pydantic import ValidationError

    try:
        return Config.model_validate(overrides)
    except ValidationError as error:
        first = error.errors()[0]
        raise UserError(f"option --{str(first['loc'][1]).replace('_', '-')}: {first['msg']}") from error
