"""The distilling workflow (paper, Fig. 1): names from the full evidence, then landmark judgement (III-G).

The paper removes texts that fail the judgement from long-term memory. They are kept here, marked: Fig. 16 shows them in
pink, and the next question may be about them.
"""

from lpslam.errors import UserError
from lpslam.language.model import LanguageModel
from lpslam.text.placing.instances import KeyframePoses
from lpslam.text.remembering.naming import name_classes
from lpslam.text.text_map import TextMap
from lpslam.text.types import Landmark

DEFAULT_QUESTION = "Is this a shop?"


def distil(
    text_map: TextMap, world_from_keyframe: KeyframePoses, language: LanguageModel, question: str = DEFAULT_QUESTION
) -> list[Landmark]:
    """Name every long-term class anew, cluster positions, and judge every landmark's name.

    The judgements are kept in the map with the model that gave them; other questions' judgements stay.

    Raises:
        UserError: the model understands nothing of the question; no judgement of the map is changed.
        LpSlamError: what the language model raises when it cannot judge.
    """
    name_classes(text_map.long_term, language, text_map.config)
    boards = {each.wording: each.wording_by_line for each in text_map.landmarks(world_from_keyframe)}
    judgements = language.judge(list(boards.values()), question) if boards else []
    if judgements and not any(each.confidence for each in judgements):
        # What is not understood is not answered with no: the map keeps the judgements that it has.
        raise UserError(judgements[0].evidence)
    text_map.judge(list(zip(boards, judgements, strict=True)), question)
    return text_map.landmarks(world_from_keyframe)
