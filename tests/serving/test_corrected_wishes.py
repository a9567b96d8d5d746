"""What was understood of a question can be sent back corrected; what is no wish is refused in one line."""

from typing import Any

import pytest
from starlette.testclient import TestClient

from lpslam.errors import UserError
from lpslam.language.offline import OfflineModel
from lpslam.serving.questions import Asked, understood, wish_text


def ask(client: TestClient, question: str, wish: Any = None) -> Any:
    body = {"question": question} | ({} if wish is None else {"wish": wish})
    return client.post("/ask", json=body)


def test_a_wish_that_is_sent_counts_and_the_question_does_not(client: TestClient) -> None:
    books = ask(client, "Where can I buy a book?").json()
    assert books["answer"]["landmark"]["name"] == "新华书店"
    other = ask(client, "Where is the nearest restaurant?", books["answer"]["wish"]).json()
    assert other["answer"]["landmark"]["name"] == "新华书店"
    assert other["understood"] == books["understood"]


def test_a_constraint_that_is_taken_out_no_longer_holds(client: TestClient) -> None:
    nearest = ask(client, "Where is the farthest restaurant?").json()
    wish = nearest["answer"]["wish"]
    assert wish["stops"][0]["which"] == "farthest"
    near = ask(client, "Where is the farthest restaurant?", wish | {"stops": [wish["stops"][0] | {"which": "nearest"}]})
    assert near.json()["answer"]["distance"] < nearest["answer"]["distance"]


def test_a_corrected_wish_holds_for_another_one_and_for_no_other_question(client: TestClient) -> None:
    books = ask(client, "Where can I buy a book?").json()["answer"]
    body = {"before": "Where is a restaurant?", "before_wish": books["wish"]}
    more = client.post("/ask", json={"question": "and another one?", **body}).json()
    assert more["answer"]["wish"] == books["wish"]
    assert more["answer"]["landmark"]["id"] == books["landmark"]["id"]
    named = {"excluded": [books["landmark"]["id"]]}
    further = client.post("/ask", json={"question": "and another one?", **body, **named}).json()
    assert further["answer"]["landmark"] is None or further["answer"]["landmark"]["id"] != books["landmark"]["id"]
    other = client.post("/ask", json={"question": "Where are the toilets?", **body}).json()
    assert other["answer"]["wish"] != books["wish"]


STOP = {"what": "a place"}
DEEP: dict[str, Any] = STOP
for _ in range(6):
    DEEP = STOP | {"anchor": [DEEP], "relation": "near"}


@pytest.mark.parametrize(
    "wish",
    [
        {},
        {"stops": []},
        {"stops": 3},
        {"stops": [{}]},
        {"stops": [STOP | {"which": "prettiest"}]},
        {"stops": [STOP | {"rank": "many"}]},
        {"stops": [DEEP]},
        {"stops": [STOP] * 25},
        {"stops": [STOP | {"without": [STOP] * 24}]},
    ],
)
def test_what_is_no_wish_is_refused_in_one_line(client: TestClient, wish: Any) -> None:
    answer = ask(client, "Where can I eat?", wish)
    assert answer.status_code == 422
    detail = answer.json()["detail"]
    assert detail.startswith("wish")
    assert "\n" not in detail


def test_a_wish_is_the_same_text_however_it_was_sent(model: OfflineModel) -> None:
    asked = Asked("Where is the nearest exit?")
    wish = understood(asked, model)["wish"]
    text = wish_text(wish)
    assert wish_text(dict(reversed(wish.items()))) == text
    assert understood(Asked("anything", wish=text), model)["wish"] == wish
    with pytest.raises(UserError, match="24 stops"):
        wish_text({"stops": [STOP] * 100})
