"""Words that mean something together are found wherever they stand."""

import pytest

from lpslam.language.languages import LANGUAGES
from lpslam.language.tables.knowledge import Knowledge, load_knowledge


@pytest.fixture(scope="module")
def knowledge() -> Knowledge:
    return load_knowledge()


@pytest.mark.parametrize("language", LANGUAGES)
def test_by_its_beginning_no_row_is_missed_that_stands_in_a_text(knowledge: Knowledge, language: str) -> None:
    states = knowledge.states(language)
    assert states.apart
    for at in range(0, len(states.apart), 37):
        text = f"{''.join(reversed(states.apart[at][0]))} "
        standing = [row for row in states.apart if all(part in text for part in row[0])]
        looked_at = states.apart_in(text)
        assert states.apart[at] in standing
        assert [row for row in looked_at if row in standing] == standing
        assert len(looked_at) < len(states.apart) / 4
