"""Score the language layer on sets whose author has not seen it, by category.

    python benchmarks/language_blind.py                     # the embedded model
    python benchmarks/language_blind.py --llm ollama:qwen3:4b --misses

Wrong is an answer that should have been another, or none; an abstention counts as missed, not as wrong.
"""

import argparse
import json
from collections import defaultdict
from pathlib import Path
from typing import Any

from lpslam.language.model import Candidate, LanguageModel, Reading
from lpslam.language.registry import language_model

SETS = Path(__file__).parent / "language"


def read(name: str) -> dict[str, Any]:
    """One blind set."""
    tree: dict[str, Any] = json.loads((SETS / f"blind_{name}.json").read_text(encoding="utf-8"))
    return tree


def judging(model: LanguageModel, name: str) -> tuple[dict[str, tuple[int, int]], list[str]]:
    """Right answers and questions by class, and the misses."""
    counts, misses = defaultdict(lambda: (0, 0)), []
    for case in read(name)["judging"]:
        names = list(case["expected"])
        for name, judged in zip(names, model.judge(names, case["question"]), strict=True):
            is_right = judged.answer == case["expected"][name]
            right, total = counts[case["class"]]
            counts[case["class"]] = (right + is_right, total + 1)
            if not is_right:
                misses.append(f"judging {name!r}, {case['question']!r}: {judged.answer} [{judged.evidence}]")
    return dict(counts), misses


def choosing(model: LanguageModel, name: str) -> tuple[dict[str, tuple[int, int, int]], list[str]]:
    """Right answers, wrong ones (rather than none) and questions by category, and the misses."""
    tree = read(name)["choosing"]
    counts, misses = defaultdict(lambda: (0, 0, 0)), []
    for case in tree["questions"]:
        names = tree["places"][case["place"]] if "place" in case else case.get("landmarks", tree.get("landmarks"))
        expected = case["expected"]
        accepted = [expected] if isinstance(expected, str) else list(expected or [])
        answer = model.choose(case["question"], [Candidate(at, name) for at, name in enumerate(names)])
        chosen = None if answer.landmark is None else names[answer.landmark]
        is_right = chosen in accepted if chosen is not None else not accepted
        right, wrong, total = counts[case["category"]]
        counts[case["category"]] = (right + is_right, wrong + (not is_right and chosen is not None), total + 1)
        if not is_right:
            misses.append(f"{case['category']}, {case['question']!r}: {chosen!r}, not {accepted} [{answer.evidence}]")
    return dict(counts), misses


def naming(model: LanguageModel, name: str) -> tuple[tuple[int, int, int], list[str]]:
    """Groups named right, groups whose commonest reading is right, and groups; and the misses."""
    right, commonest, misses = 0, 0, []
    cases = read(name)["naming"]
    for case in cases:
        answer = model.name([Reading(*reading) for reading in case["readings"]]).name
        right += answer in case["expected"]
        commonest += max(case["readings"], key=lambda reading: reading[1])[0] in case["expected"]
        if answer not in case["expected"]:
            misses.append(f"naming {answer!r}, not {case['expected'][0]!r}: {case['readings'][:4]}")
    return (right, commonest, len(cases)), misses


ORDINALS = (
    *("second", "third", "fourth", "fifth", "sixth", "seventh"),
    *("eighth", "ninth", "tenth", "eleventh", "twelfth", "thirteenth", "fourteenth", "fifteenth", "sixteenth"),
    *("seventeenth", "eighteenth", "nineteenth", "twentieth", "twenty_first", "twenty_second"),
    "twenty_third",
)


def main() -> None:
    """Print one line a category."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--llm", help="offline (the default), or a specification as of `lpslam ask --llm`")
    parser.add_argument("--misses", action="store_true", help="show every wrong answer")
    given = parser.parse_args()
    model = language_model(given.llm)
    misses: list[str] = []
    for name in ("judging", "judging_second", "judging_third"):
        judged, more = judging(model, name)
        for kind, (right, total) in judged.items():
            print(f"{name} {kind}: {right}/{total} = {right / total:.1%}")
        misses += more
    for name in ("choosing", *(f"choosing_{ordinal}" for ordinal in ORDINALS)):
        chosen, more = choosing(model, name)
        for kind, (right, wrong, total) in chosen.items():
            print(f"{name} {kind}: {right}/{total} = {right / total:.1%}, wrong {wrong}")
        wrong, total = sum(each[1] for each in chosen.values()), sum(each[2] for each in chosen.values())
        print(f"{name}, wrong rather than none: {wrong}/{total} = {wrong / total:.1%}")
        misses += more
    for name in ("naming", "naming_hard"):
        (right, commonest, total), more = naming(model, name)
        print(f"{name}: {right}/{total} = {right / total:.1%}; the commonest reading {commonest}/{total}")
        misses += more
    if given.misses:
        print(*misses, sep="\n")


if __name__ == "__main__":
    main()
