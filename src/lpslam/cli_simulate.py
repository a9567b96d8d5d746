"""The commands that render worlds: a recording of one, and the demo."""

from pathlib import Path
from typing import Annotated

import typer

from lpslam.cli_checks import config_of, refuse_with_fronts
from lpslam.cli_options import Json, Llm
from lpslam.cli_runs import render_fronts, render_simulation
from lpslam.views.printed import load_matplotlib, print_json


def simulate(
    folder: Annotated[Path, typer.Argument(metavar="OUT", help="Folder for the recording.", show_default=False)],
    seed: Annotated[int, typer.Option(min=0, help="Of the world, the walk and the noise.")] = 0,
    frames: Annotated[int | None, typer.Option(min=1, help="How many; once around the route without.")] = None,
    layout: Annotated[str | None, typer.Option(help="loop or figure-eight.")] = None,
    loop_length: Annotated[float | None, typer.Option(help="Metres.")] = None,
    light: Annotated[float | None, typer.Option(help="1 is day; 0.3 is a mall after closing time.")] = None,
    max_turn_rate: Annotated[float | None, typer.Option(help="Degrees a second.")] = None,
    language: Annotated[str | None, typer.Option(help="mixed, chinese or english.")] = None,
    duplicates: Annotated[int | None, typer.Option(help="Signs that repeat another one's words.")] = None,
    duplicate_distances: Annotated[
        str | None, typer.Option(metavar="METRES,...", help="Signs that repeat another one so far from it: 3,15.")
    ] = None,
    similar_names: Annotated[bool, typer.Option("--similar-names", help="Show GAP and GAO, EXIT and EXIT 2.")] = False,
    projecting_share: Annotated[float | None, typer.Option(help="Of the shops: signs that stand out, 0 to 1.")] = None,
    way: Annotated[str | None, typer.Option(help="around, or there-and-back: signs are seen from both sides.")] = None,
    world: Annotated[int | None, typer.Option(min=0, help="No mall: camera, motion, place of a seed.")] = None,
    factor: Annotated[list[str] | None, typer.Option(metavar="NAME=VALUE", help="Of --world: depth=tof.")] = None,
    fronts: Annotated[
        Path | None, typer.Option(metavar="FOLDER", help="No mall: shops with your pictures and labels.json.")
    ] = None,
    as_json: Json = False,
) -> None:
    """Render a mock mall, or another world: a recording in TUM layout with its ground truth and signs.json."""
    given = {
        "layout": layout,
        "loop_length": loop_length,
        "light": light,
        "max_turn_rate": max_turn_rate,
        "language": language,
        "duplicates": duplicates,
        "duplicate_distances": duplicate_distances.split(",") if duplicate_distances else None,
        "similar_names": similar_names or None,
        "projecting_share": projecting_share,
        "way": way,
    }
    options = config_of(None, {"simulation": {key: value for key, value in given.items() if value is not None}})
    if fronts is not None:
        refuse_with_fronts(frames, world, factor, given)
        render_fronts(folder, seed, fronts, options.simulation, as_json=as_json)
        return
    render_simulation(folder, seed, frames, options.simulation, world, factor or [], as_json=as_json)


def demo(
    output: Annotated[Path, typer.Option("--output", "-o", metavar="DIR", help="Where the results go.")] = Path("demo"),
    seed: Annotated[int, typer.Option(min=0, help="Which mall.")] = 4,
    frames: Annotated[int | None, typer.Option(min=3, help="Stop after N frames.")] = None,
    llm: Llm = None,
    as_json: Json = False,
) -> None:
    """Render a mall, map it, distil, ask the paper's three questions, and write map, pictures and report."""
    load_matplotlib()
    from lpslam.demo import run_demo

    report = run_demo(output, seed=seed, frames=frames, llm=llm, quiet=as_json)
    if as_json:
        print_json(report)
