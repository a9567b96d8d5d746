"""A calibration in words: as a file that can be read back, as a record, and as lines for people."""

from pathlib import Path
from typing import Any

import numpy as np

from lpslam.calibration.calibrating import Calibrated
from lpslam.calibration.lens import NAMES
from lpslam.errors import UserError
from lpslam.sources.registering.by_contours import FoundDisplacement
from lpslam.whole_files import refuse_unwritable, written_whole

_DISTORTION = NAMES[4:9]

NO_METRES = "metres are taken from the depth readings: only a true path that is long enough tells their scale"
"""What no recording of this kind tells by itself."""


def refuse_to_overwrite(path: Path, overwrite: bool) -> None:
    """Refuse, before the work, a place where the calibration could not be written, or where something is."""
    refuse_unwritable(path)
    if path.exists() and not overwrite:
        raise UserError(f"{path} is there already; give another --output, or --overwrite")


def write_calibration(found: Calibrated, source: str, path: Path) -> None:
    """Write camera.yaml: what `sources.calibration` reads, with standard deviations as comments.

    Raises:
        UserError: the file cannot be written.
    """
    with written_whole(path) as part:
        part.write_text(yaml_text(found, source), encoding="utf-8")


def yaml_text(found: Calibrated, source: str) -> str:
    """The file's content."""
    camera, sigma = found.camera, found.sigma
    lines = [f"# Estimated by lpslam calibrate from {' '.join(source.split())}: {len(found.solution.views)} views."]
    for row, name in enumerate(("fx", "fy", "cx", "cy")):
        lines.append(f"{name}: {getattr(camera, name):.4f}  # ± {sigma[row]:.2f} pixels")
    lines += [f"width: {camera.width}", f"height: {camera.height}", f"fps: {camera.fps:g}"]
    scale = f"± {camera.depth_scale * found.scale.sigma:.3g}, by the true path" if found.scale else "as it was stated"
    lines.append(f"depth_scale: {camera.depth_scale:.6g}  # {scale}")
    terms = ", ".join(f"{value:.6f}" for value in camera.distortion)
    deviations = ", ".join(f"{value:.4f}" for value in sigma[4:9])
    lines.append(f"distortion: [{terms}]  # ± {deviations}: {', '.join(_DISTORTION)}")
    if found.displacement is not None:
        lines += ["depth_displacement:", *(f"  {line}" for line in _displacement_lines(found.displacement))]
    return "\n".join(lines) + "\n"


def _displacement_lines(found: FoundDisplacement) -> list[str]:
    scale, *rest = found.displacement.numbers
    shift, parallax = (f"[{x:.3f}, {y:.3f}]" for x, y in (rest[:2], rest[2:]))
    sigma = [f"{value:.2g}" for value in found.sigma]
    return [
        f"scale: {scale:.5f}  # ± {sigma[0]}, pixels of colour in a pixel of depth",
        f"shift: {shift}  # ± {sigma[1]}, {sigma[2]} pixels",
        f"parallax: {parallax}  # ± {sigma[3]}, {sigma[4]} pixels times metres",
    ]


def record_of(found: Calibrated) -> dict[str, Any]:
    """What was found, for programs; standard deviations have `sigma_` before their name."""
    camera, halves, scale = found.camera, found.halves, found.scale
    values = [camera.fx, camera.fy, camera.cx, camera.cy, *camera.distortion]
    record: dict[str, Any] = {name: round(float(value), 6) for name, value in zip(NAMES, values, strict=False)}
    record |= {f"sigma_{name}": round(float(value), 6) for name, value in zip(NAMES[:9], found.sigma, strict=False)}
    record |= {"width": camera.width, "height": camera.height, "depth_scale": camera.depth_scale}
    record["depth_scale_is_estimated"] = scale is not None
    if scale is not None:
        record["sigma_depth_scale"] = camera.depth_scale * scale.sigma
    record |= {"readout_s": found.readout[0], "sigma_readout_s": found.readout[1]}
    record |= {"first_guess_focal": found.guess, "views": len(found.solution.views)}
    record |= {"points": len(np.unique(found.solution.seen.point)), "observations": len(found.solution.seen.view)}
    record["reprojection_rms_px"] = found.solution.pixel_rms
    record["depth_displacement"] = None
    if found.displacement is not None:
        numbers = found.displacement.displacement
        record["depth_displacement"] = {
            "scale": numbers.scale,
            "shift": list(numbers.shift),
            "parallax": list(numbers.parallax),
            "pixels": found.displacement.pixels,
        }
    record["halves"] = None
    if halves is not None:
        record["halves"] = {
            "fx": [halves.first.fx, halves.second.fx],
            "fy": [halves.first.fy, halves.second.fy],
            "cx": [halves.first.cx, halves.second.cx],
            "cy": [halves.first.cy, halves.second.cy],
            "deviations": halves.deviations,
            "mean_gap_px": halves.pixels,
            "agree": halves.agree,
        }
    return record


def lines_of(found: Calibrated) -> dict[str, str]:
    """What was found, for people."""
    camera, sigma, halves = found.camera, found.sigma, found.halves
    facts = {
        "focal length": f"{camera.fx:.2f} ± {sigma[0]:.2f}, {camera.fy:.2f} ± {sigma[1]:.2f} px",
        "principal point": f"{camera.cx:.2f} ± {sigma[2]:.2f}, {camera.cy:.2f} ± {sigma[3]:.2f} px",
    }
    for row, name in enumerate(_DISTORTION):
        if camera.distortion[row] != 0:
            facts[name] = f"{camera.distortion[row]:.4f} ± {sigma[4 + row]:.4f}"
    facts["rolling shutter"] = f"{1000 * found.readout[0]:.1f} ± {1000 * found.readout[1]:.1f} ms"
    if found.scale is not None:
        facts["depth scale"] = f"{camera.depth_scale:.5g} ± {camera.depth_scale * found.scale.sigma:.2g} (true path)"
    else:
        facts["depth scale"] = f"{camera.depth_scale:g}, as stated"
    if found.displacement is not None:
        scale, *rest = found.displacement.displacement.numbers
        shift, parallax = (f"{x:.1f}, {y:.1f}" for x, y in (rest[:2], rest[2:]))
        facts["depth displaced"] = (
            f"by {found.displacement.pixels:.0f} px: scale {scale:.3f}, shift {shift} px, parallax {parallax} px m"
        )
    facts["from"] = f"{len(found.solution.views)} views, {len(found.solution.seen.view)} observations"
    facts["error"] = f"{found.solution.pixel_rms:.2f} px"
    if halves is None:
        facts["halves"] = "too little to compare"
    else:
        verdict = "agree" if halves.agree else "do not agree"
        focals = f"fx {halves.first.fx:.1f} and {halves.second.fx:.1f}"
        facts["halves"] = f"{verdict}: {focals}; {halves.pixels:.2f} px apart"
    return facts


def warnings_of(found: Calibrated) -> list[str]:
    """What a user should know before the calibration is used."""
    warnings = [] if found.scale is not None else [NO_METRES]
    if found.halves is None:
        warnings.append("half of the recording is too little to check the calibration by; record a longer one")
    elif not found.halves.agree:
        warnings.append(
            f"the halves of the recording differ by {found.halves.pixels:.1f} px, more than their noise tells: move "
            "slowly, turn in all directions, and see that depth is registered to colour"
        )
    return warnings
