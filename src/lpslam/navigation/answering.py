"""A question answered by a map: language says what is meant, the solver where and which."""

from collections.abc import Sequence

from lpslam.language.model import LanguageModel
from lpslam.language.offline import OfflineModel, embedded_model
from lpslam.language.wishes.form import Wish
from lpslam.language.wishes.model_scoring import ModelScorer
from lpslam.language.wishes.served import Scorer
from lpslam.navigation.directory import Directory
from lpslam.navigation.places import Distances, Here
from lpslam.navigation.solution import Solution
from lpslam.navigation.solver import solve
from lpslam.text.types import Landmark


def answer_wish(
    question: str,
    landmarks: Sequence[Landmark] | Directory,
    language: LanguageModel,
    here: Here,
    ways: Distances | None = None,
    history: Sequence[tuple[str, str]] = (),
    wish: Wish | None = None,
) -> Solution:
    """Read a question into a wish and answer it by the landmarks of a map.

    The embedded model reads the wish; which landmarks serve is said by the model that is given.

    Args:
        question: in any language.
        landmarks: of the map; a `Directory` of them, where many questions are asked.
        language: says which names serve; it sees ids and strings only.
        here: where the asker stands.
        ways: distances; straight without.
        history: (question, answer) of the dialogue so far, for a model that converses.
        wish: what the question means, where somebody has said that; the question is not read then.
    """
    known = landmarks if isinstance(landmarks, Directory) else Directory(landmarks)
    embedded = language if isinstance(language, OfflineModel) else embedded_model()
    wish = wish or embedded.read_wish(question)
    scorer: Scorer
    if embedded is language:
        scorer = embedded.scorer(known.candidates)
    else:
        scorer = ModelScorer(language, known.candidates, question, wish, history)
    return solve(wish, known.sites, scorer, here, ways, known.config)
