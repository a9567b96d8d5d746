"""The arrows between packages (docs/architecture.md) hold, and a start stays light."""

import ast
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import lpslam
from small_maps import small_map

PACKAGE = Path(lpslam.__file__).parent
FOUNDATION = {
    *("_version", "assets", "camera", "config", "errors", "frames", "interruption", "isolated"),
    *("kernel_cache", "leaps"),
    *("poses", "priority", "regular_files", "small_depth", "timestamps", "whole_files"),
}

# What each part may import, besides itself and the foundation. An entry with a dot opens one module only.
ALLOWED: dict[str, set[str]] = {
    "sources": set(),
    "simulation": set(),
    "slam": set(),
    "language": set(),
    "calibration": {"sources", "slam"},
    "text": {
        "language.naming.channel",
        "language.naming.voting",
        "language.model",
        "language.sanitise",
        "language.tables.forms",
        "language.tables.knowledge",
        "language.tables.spelling",
        "slam.state",
        "slam.advice",
    },
    "ground": set(),
    "mapfile": {"slam", "text", "ground"},
    "page": {"language.languages", "language.sanitise", "text", "mapfile", "ground"},
    "navigation": {"language", "text", "mapfile", "ground"},
    "session": {"slam", "language", "text", "mapfile", "navigation", "ground"},
    "pipeline": {"sources", "slam", "language", "text", "mapfile", "navigation", "session"},
    "evaluation": {"sources", "language", "text", "mapfile"},
    "views": {
        "slam",
        "language.model",
        "language.questions.phrasing",
        "language.questions.follow_up",
        "language.wishes.form",
        "text",
        "ground",
        "mapfile",
        "navigation",
        "pipeline",
        "evaluation",
    },
    # What is served is read and asked; of tracking nothing is known here but what it tells.
    "serving": {
        "slam.state",
        *("language.model", "language.offline", "language.registry", "language.sanitise"),
        *("language.questions.follow_up", "language.questions.phrasing", "language.wishes.form"),
        *(
            "text.types",
            "text.text_map",
            "text.correcting",
            "mapfile",
            "ground",
            "page",
            "navigation",
            "session",
            "pipeline",
            "sources.open",
            "sources.in_order",
            "sources.archives",
        ),
        *("views.answers", "views.drawable", "views.pictures"),
    },
    # A run is watched by its steps and events alone.
    "watching": {
        *("language.sanitise", "text.types", "ground", "mapfile", "session", "slam.state", "sources.writing"),
    },
    # What robots are told is what a session and a map say; nothing of tracking or reading is known here.
    "robots": {
        *("language.model", "language.offline", "language.sanitise", "text.types", "ground", "mapfile", "navigation"),
        *("session", "sources", "slam.state", "views.answers"),
    },
    "demo": {"simulation", "language", "mapfile", "navigation.known", "page", "pipeline", "evaluation", "views"},
    "cli_checks": set(),
    "cli_options": set(),
    "cli_calibrate": {"sources", "calibration", "views", "cli_checks", "cli_options"},
    "cli_serving": {"language.registry", "serving", "views", "cli_checks", "cli_options"},
    "cli_correct": {
        *("language.registry", "mapfile", "navigation.known", "text.correcting", "views", "cli_checks", "cli_options"),
    },
    "cli_sources": {"sources", "views"},
    "cli_watching": {"watching", "views", "cli_checks"},
    "cli_ground": {"language", "mapfile", "navigation", "views"},
    "cli_runs": {"simulation", "language", "mapfile", "navigation.known", "pipeline", "views"},
    "cli_simulate": {"demo", "views", "cli_checks", "cli_runs", "cli_options"},
    "cli_robots": {"language.registry", "robots", "session", "views", "cli_checks", "cli_runs", "cli_options"},
    "cli_run": {
        *("language.registry", "mapfile.container", "pipeline", "sources", "views"),
        *("cli_checks", "cli_options", "cli_runs", "cli_serving", "cli_sources", "cli_watching"),
    },
    "cli": {
        *("language", "mapfile", "navigation.known", "pipeline", "evaluation", "views"),
        *(
            "cli_calibrate",
            "cli_checks",
            "cli_correct",
            "cli_ground",
            "cli_options",
            "cli_robots",
            "cli_run",
            "cli_runs",
            "cli_serving",
            "cli_simulate",
            "cli_sources",
            "page",
        ),
    },
    "__main__": {"cli"},
}
HEAVY = (
    *("cv2", "numba", "scipy", "matplotlib", "rapidocr", "openvino", "onnxruntime"),
    *("pydantic_ai", "openai", "anthropic", "google.genai", "httpx", "httpx2", "lpslam.language.hosted.exchange"),
    *("starlette", "fastapi", "uvicorn", "mcp", "rosbags", "cyclonedds", "rerun", "foxglove"),
)

FILES = sorted(path for path in PACKAGE.rglob("*.py") if path != PACKAGE / "__init__.py")


def part_of(file: Path) -> str:
    return file.relative_to(PACKAGE).parts[0].removesuffix(".py")


def imported(file: Path) -> Iterator[str]:
    """Modules of lpslam that a file imports anywhere, also inside functions, without the leading `lpslam.`."""
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        names: list[str] = []
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{file.name}: relative import"
            module = node.module or ""
            # `from lpslam.slam import map` names a module, `from lpslam.slam.map import SlamMap` does not.
            names = [f"{module}.{alias.name}" if _is_package(module) else module for alias in node.names]
        yield from (name.removeprefix("lpslam.") for name in names if name.startswith("lpslam."))


def _is_package(module: str) -> bool:
    return (PACKAGE.parent / Path(*module.split("."))).is_dir()


def allows(entries: set[str], module: str) -> bool:
    return any(module == entry or module.startswith(f"{entry}.") for entry in entries)


def against_the_arrows(file: Path) -> list[str]:
    part = part_of(file)
    reach = FOUNDATION if part in FOUNDATION else FOUNDATION | {part} | ALLOWED[part]
    return sorted({module for module in imported(file) if not allows(reach, module)})


def test_imports_follow_the_arrows() -> None:
    assert len(FILES) > 100
    wrong = {str(file.relative_to(PACKAGE)): modules for file in FILES if (modules := against_the_arrows(file))}
    assert not wrong, "must not import these; see docs/architecture.md"


def test_every_part_has_its_arrows() -> None:
    assert {part_of(file) for file in FILES} == FOUNDATION | set(ALLOWED)


def test_arrows_run_one_way() -> None:
    # The table is written from the bottom of the house to its top.
    order = list(ALLOWED)
    for part, reach in ALLOWED.items():
        assert all(order.index(entry.split(".")[0]) < order.index(part) for entry in reach), part


def test_the_check_sees_imports_inside_functions() -> None:
    assert "views.pictures" in set(imported(PACKAGE / "cli.py"))
    assert "slam.kernels.graph" in set(imported(PACKAGE / "slam" / "map.py"))


def test_kernels_know_nothing_of_images_or_files() -> None:
    for file in sorted((PACKAGE / "slam" / "kernels").glob("*.py")):
        tree = ast.parse(file.read_text(encoding="utf-8"))
        roots = {
            name.split(".")[0]
            for node in ast.walk(tree)
            if isinstance(node, ast.Import | ast.ImportFrom)
            for name in ([node.module or ""] if isinstance(node, ast.ImportFrom) else [a.name for a in node.names])
        }
        assert roots <= {"lpslam", "math", "numba", "llvmlite", "numpy", "typing"}, file.name


def test_starting_loads_nothing_heavy() -> None:
    script = f"""
import sys
import lpslam, lpslam.cli
from typer.testing import CliRunner
assert CliRunner().invoke(lpslam.cli.app, ["--help"]).exit_code == 0
print(*[name for name in {HEAVY!r} if name in sys.modules])
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == ""


def test_a_map_that_was_asked_before_is_asked_without_what_makes_maps(tmp_path: Path) -> None:
    small_map().save(tmp_path / "mall.lpmap")
    script = f"""
import sys
sys.argv = ["lpslam", "ask", {str(tmp_path / "mall.lpmap")!r}, "Where can I get a coffee?"]
import lpslam.cli
lpslam.cli.main()
print(*[name for name in {HEAVY!r} if name in sys.modules])
"""
    environment = {**os.environ, "XDG_CACHE_HOME": str(tmp_path / "cache")}
    first, again = (
        subprocess.run(
            [sys.executable, "-c", script], capture_output=True, text=True, check=True, env=environment
        ).stdout
        for _ in range(2)
    )
    assert first.startswith("Starbucks")
    assert again.splitlines()[:-1] == first.splitlines()[:-1]
    assert again.splitlines()[-1] == ""


def test_public_names_are_those_that_are_promised() -> None:
    assert sorted(lpslam.__all__) == sorted(dir(lpslam))
    assert all(getattr(lpslam, name) is not None for name in lpslam.__all__)
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = lpslam.nothing
