"""What the documents say exists: files, links, commands, and the five lines of the README."""

import re
from pathlib import Path

import pytest
from typer.main import get_command

import lpslam
from lpslam.cli import app

ROOT = Path(__file__).parents[1]
DOCUMENTS = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")])

pytestmark = pytest.mark.skipif(not (ROOT / "README.md").is_file(), reason="the documents are not beside the tests")


every_document = pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: str(path.relative_to(ROOT)))


@every_document
def test_links_lead_to_files(document: Path) -> None:
    targets = re.findall(r"\]\(([^)#\s]+)(?:#[^)]*)?\)", document.read_text(encoding="utf-8"))
    missing = [target for target in targets if "://" not in target and not (document.parent / target).exists()]
    assert not missing


def headings_of(document: Path) -> set[str]:
    """Return the headings of a document as links name them: small letters, hyphens for spaces, no other marks."""
    lines = re.findall(r"^#+ (.+)$", document.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", line.lower()).replace(" ", "-") for line in lines}


@every_document
def test_links_lead_to_headings(document: Path) -> None:
    targets = re.findall(r"\]\(([^)#\s]*)#([^)\s]+)\)", document.read_text(encoding="utf-8"))
    here = [(document.parent / file if file else document, heading) for file, heading in targets if "://" not in file]
    assert [heading for file, heading in here if heading not in headings_of(file)] == []


@every_document
def test_modules_that_are_named_exist(document: Path) -> None:
    named = re.findall(r"`((?:[\w-]+/)*[\w-]+\.py)`", document.read_text(encoding="utf-8"))
    homes = (ROOT, ROOT / "src", ROOT / "src" / "lpslam")
    missing = [
        name
        for name in named
        if not any((home / name).is_file() for home in homes) and not any(ROOT.glob(f"src/lpslam/**/{name}"))
    ]
    assert [name for name in missing if name != "__init__.py"] == []


def test_the_house_lists_every_package_and_names_only_what_exists() -> None:
    text = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    house = text.split("## The house")[1].split("Arrows run one way")[0]
    package = ROOT / "src" / "lpslam"
    for folder in sorted(path.name for path in package.iterdir() if (path / "__init__.py").is_file()):
        assert f"{folder}/" in house, f"the house has no {folder}"
    here = {path.name for path in package.rglob("*.py")}
    assert set(re.findall(r"\w+\.py", house)) <= here


def test_every_command_is_shown_and_every_shown_command_exists() -> None:
    commands = set(get_command(app).commands)  # type: ignore[attr-defined]
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    shown = set(re.findall(r"\blpslam ([a-z]+)\b", "\n".join(re.findall(r"`[^`\n]+`|^    .*$", readme, re.MULTILINE))))
    assert shown == commands


def test_options_that_the_readme_shows_exist() -> None:
    options = {
        option
        for command in get_command(app).commands.values()  # type: ignore[attr-defined]
        for parameter in command.params
        for option in parameter.opts
    }
    # Scripts beside the package have options of their own.
    readme = re.sub(r"^    python .*$", "", (ROOT / "README.md").read_text(encoding="utf-8"), flags=re.MULTILINE)
    assert set(re.findall(r"(?<![\w-])--[a-z][\w-]*", readme)) <= options | {"--help"}


def test_the_five_lines_are_those_of_the_package() -> None:
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    shown = readme.split("## The library in five lines\n```python\n")[1].split("```")[0]
    assert shown.strip() in (lpslam.__doc__ or "")
    assert len(shown.strip().splitlines()) == 5
