"""Score a language model on the paper's examples and on this project's own sets.

python benchmarks/language.py                      # the embedded model
python benchmarks/language.py --llm ollama:qwen3:4b
python benchmarks/language.py --misses             # every wrong answer in a line
python benchmarks/language.py --set paper --show   # the paper's dialogues, question by question
python benchmarks/language.py --speed              # processor time of the first answers and of the next ones
"""

import argparse
import json
import statistics
import subprocess
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING

from lpslam.language.model import Candidate, LanguageModel
from lpslam.language.registry import language_model

if TYPE_CHECKING:
    from lpslam.evaluation.language import LanguageCases

QUESTIONS = {
    "en": ("I'm thirsty", "Where can I eat pizza?", "My phone screen is cracked", "another café instead of Starbucks"),
    "zh": ("我想买手机", "我饿了", "除了肯德基还有什么吃的", "哪里可以理发"),
    "ja": ("ピアノを買いたい", "お腹が空いた", "ラーメン以外のレストラン", "薬がほしい"),
    "de": ("Ich habe Hunger", "Wo gibt es Schuhe?", "Ich mag keine Pizza", "Mein Handy ist kaputt"),
}
SETS = ("paper", "development", "second", "third", "fourth", "fifth", "sixth", "everyday", "readings")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--llm", help="offline (the default), openai:MODEL, ollama:MODEL or URL#MODEL")
    parser.add_argument("--set", choices=SETS, action="append", help="which sets; all of them unless given")
    parser.add_argument("--misses", action="store_true", help="show every wrong answer")
    parser.add_argument("--show", action="store_true", help="show every question with its answer, and why")
    parser.add_argument("--speed", action="store_true", help="time the embedded model in fresh processes instead")
    parser.add_argument("--time-answers", type=int, metavar="LANDMARKS", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.time_answers:
        time_answers(given.time_answers)
        return
    if given.speed:
        for landmarks in (25, 400, 10_000):
            subprocess.run([sys.executable, __file__, "--time-answers", str(landmarks)], check=True)
        return
    from lpslam.evaluation.language import read_cases, score_language

    start = time.process_time()
    model = language_model(given.llm)
    print(f"{model.model}: ready after {time.process_time() - start:.2f} s of processor time")
    for name in given.set or SETS:
        cases = read_cases(Path(__file__).parent / "language" / f"{name}.json")
        if given.show:
            show(model, cases)
        score = score_language(model, cases)
        print(f"{name}: {score}")
        if given.misses:
            print(*score.misses, sep="\n")


def show(model: LanguageModel, cases: "LanguageCases") -> None:
    """Print what a model is asked and what it says."""
    for group in cases.naming:
        named = model.name(group.readings)
        print(f"{' / '.join(reading.text for reading in group.readings)}\n  {named.name}: {named.evidence}")
    for case in cases.judging:
        for name, judged in zip(case.expected, model.judge(list(case.expected), case.question), strict=True):
            print(f"{case.question} {name}\n  {'yes' if judged.answer else 'no'}: {judged.evidence}")
    for asked in cases.choosing:
        marks = [Candidate(at, name) for at, name in enumerate(asked.landmarks)]
        choice = model.choose(asked.question, marks)
        chosen = "nothing here" if choice.landmark is None else asked.landmarks[choice.landmark]
        print(f"{asked.question}\n  {chosen}: {choice.evidence}")


def time_answers(landmarks: int) -> None:
    """Print the processor time from the start of this process to its first answer, and that of further ones."""
    tree = json.loads((Path(__file__).parent / "language" / "development.json").read_text(encoding="utf-8"))
    names = [name for case in tree["judging"] for name in case["expected"]]
    marks = [Candidate(at, f"{names[at % len(names)]} {at // len(names) or ''}") for at in range(landmarks)]
    model = language_model()
    model.choose("Where is the toilet?", marks)
    first = time.process_time()
    new_language, further = [], []
    for questions in QUESTIONS.values():
        spent = [seconds(model, question, marks) for question in questions]
        new_language.append(spent[0])
        further += spent[1:]
    print(
        f"{landmarks:,} landmarks: first answer after {first:.2f} s of processor time, the first in a further language "
        f"{1e3 * max(new_language):.0f} ms at most, others {1e3 * statistics.median(further):.1f} ms in the median, "
        f"{1e3 * max(further):.0f} ms at most"
    )


def seconds(model: LanguageModel, question: str, marks: list[Candidate]) -> float:
    """Processor time of one answer."""
    start = time.process_time()
    model.choose(question, marks)
    return time.process_time() - start


if __name__ == "__main__":
    main()
