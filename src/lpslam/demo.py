"""The demonstration: a mock mall is rendered, mapped as it is rendered, distilled, and asked the paper's questions."""

import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from lpslam import pipeline
from lpslam.config import Config, SimulationConfig
from lpslam.evaluation.language import paper_cases, score_language
from lpslam.evaluation.report import evaluate
from lpslam.evaluation.signs import TrueSign, listed_signs
from lpslam.evaluation.trajectory import StampedPoses
from lpslam.language.registry import language_model
from lpslam.mapfile.container import refuse_foreign_file
from lpslam.navigation.known import remember
from lpslam.page.building import write_page
from lpslam.simulation.source import MallSource
from lpslam.views.answers import answer_record, answer_text
from lpslam.views.drawable import printable
from lpslam.views.facts import fact_lines, map_facts
from lpslam.views.notes import run_notes
from lpslam.views.pictures import draw_language_map, draw_score_histories
from lpslam.views.run_progress import InterruptFlag, RunProgress, prepare
from lpslam.views.scores import score_facts, score_record
from lpslam.views.trajectory_plot import draw_trajectories
from lpslam.whole_files import refuse_unwritable_folder, written_whole

PAPER_SIGNS = (
    "KFC", "Pizza Hut", "ALIENWARE", "HUAWEI", "GUCCI", "WASHROOM", "NO SMOKING", "DANGER", "HIGH TEMPERATURE",
)  # fmt: skip
"""Names of the paper's mock mall (its Table I), which this one shows too."""


def run_demo(
    folder: Path, *, seed: int = 0, frames: int | None = None, llm: str | None = None, quiet: bool = False
) -> dict[str, Any]:
    """Run the whole path and write map.lpmap, page.html, map.png, memory.png, trajectory.png, report.md and
    report.json.

    Args:
        folder: where the results go; made if need be.
        seed: which mall.
        frames: stop after so many; once around the mall without.
        llm: which language model; the embedded one without.
        quiet: print nothing.

    Returns:
        The report.

    Raises:
        UserError: the folder cannot be written, or the language model is not known.
    """
    say: Callable[[str], None] = (lambda line: None) if quiet else print
    started = time.perf_counter()
    config = Config(simulation=SimulationConfig(featured=PAPER_SIGNS))
    language = language_model(llm, config.language)
    refuse_unwritable_folder(folder)
    folder.mkdir(parents=True, exist_ok=True)
    refuse_foreign_file(folder / "map.lpmap")

    say("Building a mock mall, and walking through it with a simulated RGB-D camera ...")
    prepare()
    source = MallSource(seed, frames, options=config.simulation)
    with InterruptFlag() as interrupted, RunProgress(len(source), quiet) as progress:
        world = pipeline.run(
            source, config, language=language, on_progress=progress.update, should_stop=interrupted.is_set
        )
    if interrupted.is_set():
        say("Stopped early; here is what the map so far gives.")
    for note in run_notes(world, source.faults, progress.first_untracked, language.model):
        say(f"Note: {printable(note, longest=1000)}")
    landmarks = pipeline.distill(world, language=language)
    remember(world, world.save(folder / "map.lpmap"), landmarks)

    truth = StampedPoses(source.ground_truth.timestamps, source.ground_truth.world_from_camera)
    scores = evaluate(world, truth, true_signs(source), len(source), config.evaluation)
    page = write_page(world, folder / "page.html", config.page)
    draw_language_map(world, folder / "map.png")
    draw_score_histories(world, folder / "memory.png")
    draw_trajectories(folder / "trajectory.png", truth, world.frame_poses(), scores.ate, title=source.name)

    cases = paper_cases()
    answers = [pipeline.ask(world, case.question, language=language) for case in cases.choosing]
    language_score = score_language(language, cases)
    seconds = time.perf_counter() - started
    facts = map_facts(world)
    lines = [f"{key}: {value}" for key, value in {**fact_lines(facts), **score_facts(scores)}.items()]
    asked = [f"{answer.question}\n{answer_text(answer)}" for answer in answers]
    report = {
        "map": facts,
        "scores": score_record(scores),
        "answers": [answer_record(answer) for answer in answers],
        "language": str(language_score),
        "seconds": round(seconds, 1),
    }
    _write_report(folder, source.name, lines, asked, str(language_score), seconds)
    with written_whole(folder / "report.json", "the report") as part:
        part.write_text(json.dumps(report, ensure_ascii=False, indent=1) + "\n", encoding="utf-8")

    say("\n".join(["", *lines, "", *asked, "", f"language, on the paper's own examples: {language_score}"]))
    say(f"\nWritten to {folder}/ in {seconds:.0f} s: map.lpmap, map.png, memory.png, trajectory.png, report.md")
    say(f"The map in a browser: {page.resolve()}")
    return report


def true_signs(mall: MallSource) -> list[TrueSign]:
    """The signs of a mall as its signs.json would list them."""
    return listed_signs([sign.as_json() for sign in mall.signs], mall.name)


def _write_report(
    folder: Path, name: str, scores: list[str], asked: list[str], language_score: str, seconds: float
) -> None:
    # Indented by four, so that what was read in the world is shown as it is and never taken for markup.
    indented = ["    " + line for answer in asked for line in [*answer.splitlines(), ""]]
    report = [
        f"# {name}",
        "",
        f"Rendered, mapped, distilled and asked in {seconds:.0f} s.",
        "",
        "![the map from above](map.png)",
        "",
        "[The map in a browser](page.html)",
        "",
        *[f"    {line}" for line in scores],
        "",
        "## Questions",
        "",
        *indented,
        "## The paper's own examples",
        "",
        f"    {language_score}",
        "",
        "![memory scores](memory.png)",
        "![trajectory](trajectory.png)",
    ]
    with written_whole(folder / "report.md", "the report") as part:
        part.write_text("\n".join(report) + "\n", encoding="utf-8")
