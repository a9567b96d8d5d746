"""Score a language model on the paper's examples and on this project's own sets.

python benchmarks/language.py                      # the embedded model
python benchmarks/language.py --llm ollama:qwen3:4b
python benchmarks/language.py --misses             # every wrong answer in a line
"""

import argparse
import time
from pathlib import Path

from lpslam.evaluation.language import read_cases, score_language
from lpslam.language.model import Candidate
from lpslam.language.registry import language_model

SETS = ("paper", "development", "second", "third", "fourth")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--llm", help="offline (the default), openai:MODEL, ollama:MODEL or URL#MODEL")
    parser.add_argument("--set", choices=SETS, action="append", help="which sets; all of them unless given")
    parser.add_argument("--misses", action="store_true", help="show every wrong answer")
    given = parser.parse_args()
    start = time.process_time()
    model = language_model(given.llm)
    print(f"{model.model}: ready after {time.process_time() - start:.2f} s of processor time")
    for name in given.set or SETS:
        score = score_language(model, read_cases(Path(__file__).parent / "language" / f"{name}.json"))
        print(f"{name}: {score}")
        if given.misses:
            print(*score.misses, sep="\n")
    if given.llm is None:
        print(f"choosing among 400 landmarks: {1e3 * seconds_a_choice(400):.1f} ms")


def seconds_a_choice(landmarks: int) -> float:
    """Processor time of one answer once the signs have been read, median of five questions."""
    cases = read_cases(Path(__file__).parent / "language" / "development.json")
    names = [name for case in cases.judging for name in case.expected]
    marks = [Candidate(at, f"{names[at % len(names)]} {at // len(names) or ''}") for at in range(landmarks)]
    model = language_model()
    model.choose("Where is the toilet?", marks)
    seconds = []
    for question in ("I'm thirsty", "我想买手机", "ピアノを買いたい", "Where can I eat pizza?", "Ich habe Hunger"):
        start = time.process_time()
        model.choose(question, marks)
        seconds.append(time.process_time() - start)
    return sorted(seconds)[2]


if __name__ == "__main__":
    main()
