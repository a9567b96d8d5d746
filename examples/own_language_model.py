"""Ask a map with a language model of one's own: `own_language_model.py MAP.lpmap QUESTION`."""

import sys
from collections.abc import Sequence

import lpslam
from lpslam.language.model import Candidate, Choice, Judgement, Naming, Reading


class Literal:
    """Takes every sign at its word; a model of one's own asks something cleverer. It sees no position."""

    model = "literal"

    def name(self, readings: Sequence[Reading]) -> Naming:
        """The spelling that was read most often."""
        most = max(readings, key=lambda reading: reading.count)
        return Naming(most.text, most.confidence, "read most often", self.model)

    def judge(self, names: Sequence[str], question: str) -> list[Judgement]:
        """Everything is a landmark."""
        return [Judgement(question, True, 0.5, "a sign is a sign", self.model) for _ in names]

    def choose(self, question: str, landmarks: Sequence[Candidate]) -> Choice:
        """The first sign whose name the question says."""
        said = [each.id for each in landmarks if each.name.casefold() in question.casefold()]
        return Choice(said[0] if said else None, 1.0, "named in the question", self.model, tuple(said[1:]))


if __name__ == "__main__":
    answer = lpslam.ask(lpslam.LanguageMap.load(sys.argv[1]), sys.argv[2], language=Literal())
    print(answer.landmark.name if answer.landmark else "nothing here is called that", answer.choice.evidence)
