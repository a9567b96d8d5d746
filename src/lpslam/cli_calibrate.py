"""The command `lpslam calibrate`."""

from pathlib import Path
from typing import Annotated

import typer

from lpslam.cli_checks import config_of
from lpslam.cli_options import Json
from lpslam.views.printed import print_json, print_table, say


def calibrate(
    source: Annotated[
        Path,
        typer.Argument(metavar="RECORDING", help="Folder of a recording: TUM RGB-D or 7-Scenes.", show_default=False),
    ],
    output: Annotated[Path, typer.Option("--output", "-o", metavar="FILE", help="Where the calibration goes.")] = Path(
        "camera.yaml"
    ),
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Even if that file is there already.")] = False,
    max_frames: Annotated[int | None, typer.Option("--max-frames", min=1, help="Use only the first N frames.")] = None,
    config: Annotated[
        Path | None, typer.Option("--config", metavar="FILE", help="YAML overrides of thresholds; see 'lpslam config'.")
    ] = None,
    as_json: Json = False,
) -> None:
    """Estimate the camera's calibration from a recording of any textured room.

    The camera should turn left and right, up and down, and about its axis. What the recording's own calibration states
    is not used, but for the depth scale: with groundtruth.txt that is estimated as well.
    """
    from lpslam.calibration.calibrating import calibrate as estimate
    from lpslam.calibration.report import lines_of, record_of, refuse_to_overwrite, warnings_of, write_calibration
    from lpslam.sources.ground_truth import read_ground_truth
    from lpslam.sources.open import open_uncalibrated
    from lpslam.views.run_progress import counting, prepare

    refuse_to_overwrite(output, overwrite)
    settings = config_of(config)
    recording = open_uncalibrated(source, max_frames, settings.calibration)
    truth = read_ground_truth(source)
    prepare()
    with counting("looking for views") as progress:
        found = estimate(recording, settings, truth, progress)
    for warning in warnings_of(found):
        say(f"{recording.name}: {warning}")
    write_calibration(found, recording.name, output)
    if as_json:
        print_json({"written": str(output), **record_of(found)})
    else:
        print_table({"written": str(output), **lines_of(found)})
