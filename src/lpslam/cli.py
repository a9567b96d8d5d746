"""The command line: parse, call, print."""

import json
import os
from pathlib import Path
from typing import Annotated, Any

import typer

from lpslam._version import __version__
from lpslam.cli_calibrate import calibrate
from lpslam.cli_checks import config_of
from lpslam.cli_correct import correct
from lpslam.cli_options import ConfigFile, Json, Llm
from lpslam.cli_robots import COMMANDS as ROBOTS
from lpslam.cli_run import run
from lpslam.cli_runs import call_to_its_end, keep, parse_and_call, say_usage
from lpslam.cli_serving import COMMANDS as SERVING
from lpslam.cli_simulate import demo, simulate
from lpslam.cli_sources import convert, record, sources
from lpslam.views.printed import (
    facts_of,
    landmark_records,
    load_matplotlib,
    prepare_streams,
    print_facts,
    print_json,
    print_landmarks,
    print_table,
    print_written,
    say,
)

app = typer.Typer(
    name="lpslam",
    help="Language-perceptive RGB-D SLAM: a map whose landmarks are the words in the scene.",
    add_completion=False,
    pretty_exceptions_enable=False,
)

MapFile = Annotated[
    Path, typer.Argument(metavar="MAP", help="A map made by 'lpslam run' (.lpmap).", show_default=False)
]


def main() -> None:
    """Run the command line; a user's mistake is one line on standard error and exit code 2."""
    # Kernels, OpenCV and the reading engine share two cores best with one thread each.
    for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
        os.environ.setdefault(variable, "1")
    prepare_streams()
    call_to_its_end(lambda: parse_and_call(app))


app.command()(calibrate)
app.command()(correct)
app.command()(convert)
app.command()(record)
app.command()(sources)
app.command()(simulate)
app.command()(demo)
for _command in (*SERVING, *ROBOTS, run):
    app.command()(_command)


@app.callback(invoke_without_command=True)
def _options(
    context: typer.Context, version: Annotated[bool, typer.Option("--version", help="Print the version.")] = False
) -> None:
    if version:
        print(f"lpslam {__version__}")
        raise typer.Exit
    if context.invoked_subcommand is None:
        print(context.get_help(), end="")
        raise typer.Exit(2)


@app.command()
def distill(
    map_file: MapFile,
    judge: Annotated[str, typer.Option("--judge", metavar="QUESTION", help="What makes a text a landmark?")] = (
        "Is this a shop?"
    ),
    llm: Llm = None,
    config: ConfigFile = None,
    as_json: Json = False,
) -> None:
    """Name and judge the map's texts; the judgements are kept in the map."""
    from lpslam import pipeline
    from lpslam.errors import LpSlamError
    from lpslam.language.registry import language_model
    from lpslam.mapfile.correcting import editing
    from lpslam.mapfile.language_map import LanguageMap
    from lpslam.views.notes import judging_notes, naming_notes

    language = language_model(llm, config_of(config).language)
    failure: LpSlamError | None = None
    # What a person corrects meanwhile waits, and is not overwritten.
    with editing(map_file, must_lock=False):
        world = LanguageMap.load(map_file)
        landmarks = pipeline.distill(world, judge, language=language)
        try:
            keep(world, map_file, is_held=True, landmarks=landmarks)
        except LpSlamError as error:
            failure = error
    for note in naming_notes(world, language.model) + judging_notes(landmarks, judge, language.model):
        say(note)
    say_usage(language)
    print_landmarks(landmarks, judge, as_json)
    if failure is not None:
        raise failure


@app.command()
def ask(
    map_file: MapFile,
    question: Annotated[
        str | None,
        typer.Argument(metavar="QUESTION", help="In any language; a prompt without.", show_default=False),
    ] = None,
    place: Annotated[
        str | None,
        typer.Option(
            "--from", metavar="X,Y[,HEADING]", help="Where the robot is: metres, degrees from x; else the last frame's."
        ),
    ] = None,
    llm: Llm = None,
    why: Annotated[bool, typer.Option("--why", help="Say first what was understood of the question.")] = False,
    way: Annotated[bool, typer.Option("--way", help="Say also where to stand, and how to go there.")] = False,
    config: ConfigFile = None,
    as_json: Json = False,
) -> None:
    """Ask the map for a place: 'Where can I eat pizza?'; without a question, at a prompt.

    At the prompt, or from a pipe with a question a line, "and another one?" means what was asked before.
    """
    from lpslam.language.kept import building

    # What is loaded is no garbage either.
    with building():
        from lpslam.errors import UserError
        from lpslam.language.registry import language_model
        from lpslam.navigation.known import known_in
        from lpslam.views.answers import answer_record
        from lpslam.views.dialogue import Dialogue, parsed_place, questions

    position, heading = parsed_place(place) if place is not None else (None, None)
    settings = config_of(config)
    language = language_model(llm, settings.language)
    with building():
        dialogue = Dialogue(known_in(map_file), language, position, heading, settings)
    guide = _guide_in(map_file, settings) if way else None
    longest = settings.language.question_length
    for text in questions() if question is None else (question,):
        if len(text) > longest:
            say(f"the question has {len(text):,} letters; its first {longest} are read")
        try:
            answer = dialogue.ask(text)
        except UserError as error:
            if question is not None:
                raise
            say(str(error))
            continue
        if as_json:
            record = {**answer_record(answer), **(guide.record(answer) if guide is not None else {})}
            print(json.dumps(record, ensure_ascii=False, indent=1 if question is not None else None))
        else:
            print(dialogue.said(answer, understood=why), flush=True)
            if guide is not None:
                print(guide.said(answer), flush=True)
    say_usage(language)


def _guide_in(map_file: Path, settings: Any) -> Any:
    """What tells the way in a map. Its ground is most of what a map file holds; without a way nothing of it is read."""
    from lpslam.cli_ground import Guide
    from lpslam.mapfile.language_map import LanguageMap

    return Guide(LanguageMap.load(map_file), settings)


@app.command()
def info(map_file: MapFile, as_json: Json = False) -> None:
    """Say what a map holds."""
    from dataclasses import asdict

    from lpslam.mapfile.language_map import LanguageMap

    world = LanguageMap.load(map_file)
    if as_json:
        events = [asdict(event) for event in world.events]
        record = {**facts_of(world, map_file), "statistics": world.statistics, "events": events}
        print_json({**record, **landmark_records(world.landmarks())})
    else:
        print_facts(world, map_file, as_json)
        print_landmarks(world.landmarks(), "Texts in long-term memory", as_json)


@app.command()
def export(
    map_file: MapFile,
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Where the files go.", show_default=False)],
    html: Annotated[bool, typer.Option("--html", help="Also page.html, which shows the map without a server.")] = False,
    nav2: Annotated[
        bool, typer.Option("--nav2", help="Also the ground: map.pgm, keepout, waypoints, GeoJSON, a floor plan.")
    ] = False,
    route: Annotated[
        str | None, typer.Option("--route", metavar="QUESTION", help="With --nav2: the way to its answer, route.yaml.")
    ] = None,
    config: ConfigFile = None,
    as_json: Json = False,
) -> None:
    """Write trajectory.txt and keyframes.txt (TUM format), landmarks.json and cloud.ply."""
    from lpslam.cli_ground import Guide
    from lpslam.mapfile.export import export_map
    from lpslam.mapfile.language_map import LanguageMap

    settings = config_of(config)
    world = LanguageMap.load(map_file)
    # A map without ground, or a question that nothing answers, is told before anything is written.
    write_ground = Guide(world, settings).ready_to_export(route) if nav2 or route is not None else None
    written = export_map(world, folder)
    if html:
        from lpslam.page.building import write_page

        written.append(write_page(world, folder / "page.html", settings.page))
    if write_ground is not None:
        written += write_ground(folder)
    print_written(written, as_json)


@app.command()
def draw(
    map_file: MapFile,
    output: Annotated[Path, typer.Argument(metavar="OUT.png", help="The picture (.png, .pdf, .svg).")],
    memory: Annotated[bool, typer.Option("--memory", help="Draw how memory scores rose and faded (Fig. 13).")] = False,
    as_json: Json = False,
) -> None:
    """Draw the map from above: landmarks in blue, other texts in pink (Fig. 16)."""
    load_matplotlib()
    from lpslam.mapfile.language_map import LanguageMap
    from lpslam.views.pictures import draw_language_map, draw_score_histories

    world = LanguageMap.load(map_file)
    if memory:
        draw_score_histories(world, output)
    print_written([output] if memory else draw_language_map(world, output), as_json)


@app.command(name="eval")
def evaluate(
    map_file: MapFile,
    sequence: Annotated[
        Path, typer.Argument(metavar="SEQUENCE", help="The recording, with its ground truth.", show_default=False)
    ],
    camera: Annotated[
        Path | None, typer.Option("--camera", metavar="FILE", help="As given to 'lpslam run', if it was.")
    ] = None,
    config: ConfigFile = None,
    as_json: Json = False,
) -> None:
    """Score a map against ground truth: trajectory error, frames tracked, landmarks."""
    from lpslam.evaluation.report import evaluate_recording
    from lpslam.mapfile.language_map import LanguageMap
    from lpslam.views.scores import score_facts, score_record

    scores = evaluate_recording(LanguageMap.load(map_file), sequence, config_of(config).evaluation, camera)
    if as_json:
        print_json(score_record(scores))
    else:
        print_table(score_facts(scores))


@app.command(name="config")
def show_config() -> None:
    """Print every threshold with its default, its unit and its reason, as YAML that --config takes."""
    from lpslam.config import Config
    from lpslam.views.thresholds import commented_yaml

    print(commented_yaml(Config()))
