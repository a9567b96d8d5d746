"""What the HTTP API answers, by its published schemas."""

import inspect
import json
import os
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from served_here import Serve
from starlette.testclient import TestClient

from command_line import Command
from lpslam.config import Config
from lpslam.language.offline import OfflineModel
from lpslam.serving import records
from lpslam.serving.assembling import assemble
from lpslam.serving.http.routes import needs
from lpslam.serving.tokens import Tokens, add_token
from small_maps import small_map, with_floor


def test_the_maps_are_listed_by_the_schema(client: TestClient) -> None:
    (listed,) = records.MapList.model_validate(client.get("/maps").json()).maps
    assert (listed.name, listed.landmarks, listed.source, listed.has_ground) == ("mall", 8, "small", False)
    assert client.get("/maps/mall").json() == listed.model_dump()
    assert client.get("/maps/other").status_code == 404


def test_who_may_ask_is_told_without_a_thread() -> None:
    # Plain functions are sent to a thread with every request, which cost more than all else of the server.
    assert inspect.iscoroutinefunction(needs("ask").dependency)


def test_landmarks_are_filtered_sorted_and_paged(client: TestClient) -> None:
    def page(**query: object) -> records.LandmarkPage:
        response = client.get("/landmarks", params={key: str(value) for key, value in query.items()})
        assert response.status_code == 200, response.text
        return records.LandmarkPage.model_validate(response.json())

    everything = page()
    assert (everything.total, [mark.id for mark in everything.landmarks]) == (8, [1000 * at for at in range(8)])
    first, second = page(size=5), page(size=5, page=2)
    assert [mark.id for mark in (*first.landmarks, *second.landmarks)] == [mark.id for mark in everything.landmarks]
    assert (page(page=99).landmarks, page(page=99).total) == ([], 8)
    assert [mark.name for mark in page(text="pizza").landmarks] == ["Pizza Hut 必胜客"]
    assert [mark.name for mark in page(text="书店").landmarks] == ["新华书店"]
    nearest = page(near="9,0", size=3).landmarks
    assert [(mark.name, mark.distance) for mark in nearest] == [
        ("新华书店", 1.0), ("Toilets", 3.0), ("Pizza Hut 必胜客", 5.0)
    ]  # fmt: skip
    assert page(near="9,0", within=3.5).total == 2
    assert page(judged="unjudged").total == 8
    assert page(judged="yes").total == page(role="contact").total == page(confidence=1.0).total == 0


@pytest.mark.parametrize(
    "query",
    ["near=nan,0", "near=1", "near=1,2,3,4", "near=inf,1", "near=1e300,0", "near=a,b", "near=", "within=3",
     "near=0,0&within=nan", "near=0,0&within=-1", "page=0", "page=-1", "page=1e9", "page=99999999999999999999999",
     "size=0", "size=100000", "size=a", "judged=perhaps", "confidence=nan", "confidence=2", f"text={'x' * 300}"],
)  # fmt: skip
def test_a_query_that_means_nothing_is_refused_in_one_line(client: TestClient, query: str) -> None:
    response = client.get(f"/landmarks?{query}")
    assert response.status_code == 422
    said = records.Problem.model_validate(response.json())
    assert response.headers["content-type"] == "application/problem+json"
    assert "\n" not in said.detail


def test_one_landmark_is_that_of_the_list(client: TestClient) -> None:
    listed = client.get("/landmarks").json()["landmarks"][3]
    assert client.get("/landmarks/3000").json() == listed
    for missing in ("1", "-1", "99999999999999999999999999"):
        assert client.get(f"/landmarks/{missing}").status_code == 404


QUESTIONS = (
    "Where can I eat pizza?",
    "哪里可以买书？",
    "a place that sells aeroplanes",
    "the toilet next to the bookshop",
)


@pytest.mark.parametrize("question", QUESTIONS)
def test_an_answer_is_the_one_of_the_command_line(
    client: TestClient, lpslam: Command, mall: Path, question: str
) -> None:
    given = client.post("/ask", json={"question": question, "position": [3.0, 1.5], "heading": 90})
    envelope = records.AnswerEnvelope.model_validate(given.json())
    assert given.json()["answer"] == lpslam("ask", mall, question, "--from", "3,1.5,90", "--json").json
    assert envelope.map == "mall"
    assert envelope.text


def test_kinds_are_told_in_the_language_of_the_question(client: TestClient) -> None:
    answered = client.post("/ask", json={"question": "Wo kann ich Pizza essen?"}).json()
    assert set(answered["kinds"]) == set(answered["answer"]["wish"]["stops"][0]["kinds"])
    assert "Pizza" in answered["kinds"].values()


def test_another_one_is_another_one(client: TestClient) -> None:
    first = client.post("/ask", json={"question": "Where can I get something to eat?"}).json()["answer"]
    again = {
        "question": "and another one?",
        "before": "Where can I get something to eat?",
        "excluded": [first["landmark"]["id"]],
    }
    second = client.post("/ask", json=again).json()["answer"]
    assert {first["landmark"]["name"], second["landmark"]["name"]} <= {"Pizza Hut 必胜客", "KFC", "Starbucks"}
    assert first["landmark"]["id"] != second["landmark"]["id"]


def test_a_stream_says_first_what_was_understood(client: TestClient) -> None:
    asked = {"question": "Where can I eat pizza?"}
    response = client.post("/ask", json=asked, headers={"accept": "text/event-stream"})
    assert response.headers["content-type"].startswith("text/event-stream")
    events = [block.split("\n") for block in response.text.strip().split("\n\n")]
    assert [lines[0] for lines in events] == ["event: understood", "event: answer"]
    assert json.loads(events[1][1].removeprefix("data: ")) == client.post("/ask", json=asked).json()
    problem = client.post("/ask", json={"question": " "}, headers={"accept": "text/event-stream"})
    assert "event: problem" in problem.text


def test_where_there_is_no_ground_it_is_said_in_one_line(client: TestClient) -> None:
    for response in (
        client.post("/goal", json={"landmark": 1000}),
        client.post("/path", json={"question": "pizza", "position": [0, 0]}),
        client.get("/grid.png"),
        client.get("/grid"),
    ):
        assert response.status_code == 501
        assert "no ground" in records.Problem.model_validate(response.json()).detail


def test_a_map_that_saw_a_floor_gives_its_grid(serve: Serve, tmp_path: Path) -> None:
    path = tmp_path / "floor.lpmap"
    with_floor(small_map(spacing=5.5)).save(path)
    client = serve(path)
    assert client.get("/maps/floor").json()["has_ground"]
    facts = records.GridRecord.model_validate(client.get("/grid").json())
    picture = cv2.imdecode(np.frombuffer(client.get("/grid.png").content, np.uint8), cv2.IMREAD_UNCHANGED)
    assert picture.shape == (facts.height, facts.width)
    assert (int((picture == 254).sum()), int((picture == 0).sum())) == (facts.free, facts.occupied)
    # From where the camera sees it there is floor; behind the camera nobody has looked.
    for (x, y), shade in {(3.6, 0.0): 254, (-0.04, 0.0): 254, (3.0, 5.0): None}.items():
        column, row = int((x - facts.origin[0]) / facts.resolution), int((y - facts.origin[1]) / facts.resolution)
        if shade is None:
            assert not 0 <= row < facts.height or picture[facts.height - 1 - row, column] == 205
        else:
            assert picture[facts.height - 1 - row, column] == shade
    goal = records.GoalRecord.model_validate(client.post("/goal", json={"landmark": 1000, "position": [3.6, 0]}).json())
    way = records.PathRecord.model_validate(
        client.post("/path", json={"question": "Wo gibt es Pizza?", "position": [3.6, 0], "heading": 0}).json()
    )
    assert (goal.landmark, way.landmark, way.position) == (1000, 1000, goal.position)
    assert goal.is_before_the_sign
    # The board at (5.5, 0) faces the camera at the origin: one stands between the two and looks along x.
    assert 3.6 < goal.position[0] < 5.5
    assert min(goal.heading, 360.0 - goal.heading) < 30
    assert way.points[0] == pytest.approx([3.6, 0], abs=0.1)
    assert way.points[-1] == pytest.approx(goal.position, abs=0.1)
    assert way.length == pytest.approx(goal.position[0] - 3.6, abs=0.3)
    assert "Pizza Hut" in way.steps[-1]
    (leg,) = way.legs
    assert (leg.points, leg.steps) == (way.points, way.steps)
    german = client.post("/path", json={"landmark": 1000, "position": [3.6, 0], "language": "de"}).json()
    assert german["steps"] == way.steps != client.post("/path", json={"landmark": 1000, "position": [3.6, 0]}).json()
    for body in ({}, {"landmark": 1000, "question": "pizza"}, {"question": "an aeroplane"}):
        assert client.post("/goal", json=body).status_code == 422
    nowhere = client.post("/path", json={"landmark": 1000, "position": [90, 90]})
    assert (nowhere.status_code, "no way" in nowhere.json()["detail"]) == (422, True)
    assert client.post("/goal", json={"landmark": 77}).status_code == 404


def test_a_plan_is_one_way_through_its_stops(serve: Serve, tmp_path: Path) -> None:
    path = tmp_path / "floor.lpmap"
    with_floor(small_map(signs=("ATM", "EXIT 1", "Pizza Hut 必胜客", "KFC"), spacing=2.5)).save(path)
    client = serve(path)
    ids = {mark["name"]: mark["id"] for mark in client.get("/landmarks").json()["landmarks"]}
    pizza, kfc = ids["Pizza Hut 必胜客"], ids["KFC"]
    body = {"landmark": kfc, "via": [pizza], "position": [3.6, 0.0]}
    way = records.PathRecord.model_validate(client.post("/path", json=body).json())
    assert [leg.landmark for leg in way.legs] == [pizza, kfc]
    assert (way.landmark, way.position) == (kfc, way.legs[1].position)
    assert way.legs[0].position == pytest.approx(way.legs[1].points[0], abs=0.1)
    assert way.length == pytest.approx(sum(leg.length for leg in way.legs), abs=0.02)
    assert way.steps == [step for leg in way.legs for step in leg.steps]
    assert way.points == [*way.legs[0].points, *way.legs[1].points[1:]]
    asked = client.post("/path", json={"question": "first Pizza Hut, then KFC", "position": [3.6, 0.0]}).json()
    assert [leg["landmark"] for leg in asked["legs"]] == [pizza, kfc]
    assert client.post("/path", json={**body, "via": [77]}).status_code == 404
    assert client.post("/path", json={**body, "via": [pizza] * 25}).status_code == 422


def test_the_schema_covers_every_route_and_says_nothing_of_pages_elsewhere(client: TestClient) -> None:
    schema = client.get("/openapi.json").json()
    assert set(schema["paths"]) == {
        "/health", "/maps", "/maps/{name}", "/landmarks", "/landmarks/{id_}", "/map.png", "/grid.png", "/grid",
        "/events", "/ask",
        "/goal", "/path", "/corrections", "/corrections/{number}", "/jobs", "/jobs/{id_}",
    }  # fmt: skip
    assert {"AnswerEnvelope", "LandmarkPage", "Problem", "JobRecord"} <= set(schema["components"]["schemas"])
    assert client.get("/docs").status_code == client.get("/redoc").status_code == 404
    assert "http" not in json.dumps(schema).replace("httpx", "")


def test_every_response_is_shut_to_other_origins(client: TestClient) -> None:
    for response in (
        client.get("/maps"),
        client.get("/nothing"),
        client.post("/ask", content=b"{"),
        client.get("/ask"),
    ):
        assert "default-src 'none'" in response.headers["content-security-policy"]
        assert response.headers["x-content-type-options"] == "nosniff"
        assert response.headers["cross-origin-resource-policy"] == "same-origin"
        assert not [name for name in response.headers if name.startswith("access-control")]
    preflight = client.options(
        "/ask", headers={"origin": "http://evil.example", "access-control-request-method": "POST"}
    )
    assert preflight.status_code == 403


def test_the_picture_is_drawn_once(client: TestClient) -> None:
    first = client.get("/map.png")
    assert first.headers["content-type"] == "image/png"
    assert first.content.startswith(b"\x89PNG")
    assert client.get("/map.png").content == first.content


def test_several_maps_are_asked_by_name(serve: Serve, mall: Path, tmp_path: Path) -> None:
    small_map(["Tickets", "Platform 2"]).save(tmp_path / "a station!.lpmap")
    client = serve(mall, tmp_path / "a station!.lpmap")
    assert [each["name"] for each in client.get("/maps").json()["maps"]] == ["mall", "a-station"]
    assert client.get("/landmarks").status_code == 404
    assert client.get("/landmarks?map=a-station").json()["total"] == 2
    assert client.post("/ask", json={"question": "tickets", "map": "a-station"}).json()["answer"]["landmark"]["id"] == 0
    for name in ("../mall", "mall.lpmap", str(mall), "a station!", "%00", "mall\x00", "MALL"):
        assert client.get("/landmarks", params={"map": name}).status_code in (404, 422)
        assert client.post("/ask", json={"question": "x", "map": name}).status_code in (404, 422)


def test_a_map_that_is_replaced_is_served_anew_and_a_damaged_one_as_it_was(serve: Serve, mall: Path) -> None:
    client = serve(look_s=0.05)
    before = client.get("/maps/mall").json()

    def until(check: Any) -> Any:
        import time

        for _ in range(200):
            found = client.get("/maps/mall").json()
            if check(found):
                return found
            time.sleep(0.05)
        raise AssertionError(found)

    small_map(["Bakery"]).save(mall)
    after = until(lambda found: found["version"] != before["version"])
    assert after["landmarks"] == 1
    assert client.post("/ask", json={"question": "bakery"}).json()["answer"]["landmark"]["name"] == "Bakery"
    mall.write_bytes(b"this is no map")
    damaged = until(lambda found: found["trouble"])
    assert (damaged["landmarks"], damaged["version"]) == (1, after["version"])
    assert "/" not in damaged["trouble"]
    os.unlink(mall)
    assert client.post("/ask", json={"question": "bakery"}).status_code == 200
    small_map(["Florist", "Bakery"]).save(mall)
    assert until(lambda found: not found["trouble"] and found["landmarks"] == 2)


@pytest.fixture
def tokens(tmp_path: Path) -> tuple[Path, dict[str, str]]:
    path = tmp_path / "tokens.json"
    made = {
        "reader": add_token(path, "reader", ["read"], 1),
        "asker": add_token(path, "asker", ["read", "ask"], None),
        "late": add_token(path, "late", ["read", "ask", "map"], 0),
    }
    return path, made


def bearer(token: str) -> dict[str, str]:
    return {"authorization": f"Bearer {token}"}


def test_tokens_let_in_as_far_as_their_scopes(serve: Serve, tokens: tuple[Path, dict[str, str]]) -> None:
    path, made = tokens
    client, question = serve(tokens=path), {"question": "pizza"}
    assert client.get("/health").status_code == 200
    for headers in ({}, bearer("lps_guess"), bearer(""), {"authorization": made["reader"]}, bearer("x" * 9000)):
        refused = client.get("/maps", headers=headers)
        assert refused.status_code == 401, headers
        assert refused.headers["www-authenticate"].startswith("Bearer")
    assert client.get("/maps", headers=bearer(made["reader"])).status_code == 200
    assert client.post("/ask", json=question, headers=bearer(made["reader"])).status_code == 403
    assert client.post("/ask", json=question, headers=bearer(made["asker"])).status_code == 200
    assert client.get("/jobs", headers=bearer(made["asker"])).status_code == 403
    late = client.get("/maps", headers=bearer(made["late"]))
    assert (late.status_code, "expired" in late.json()["detail"]) == (401, True)


def test_a_token_is_withdrawn_while_the_server_runs(serve: Serve, tokens: tuple[Path, dict[str, str]]) -> None:
    path, made = tokens
    client = serve(tokens=path)
    assert client.get("/maps", headers=bearer(made["asker"])).status_code == 200
    document = json.loads(path.read_text())
    document["tokens"] = [each for each in document["tokens"] if each["name"] != "asker"]
    path.write_text(json.dumps(document))
    assert client.get("/maps", headers=bearer(made["asker"])).status_code == 401
    assert client.get("/maps", headers=bearer(made["reader"])).status_code == 200
    path.write_text("{")
    assert client.get("/maps", headers=bearer(made["reader"])).status_code == 401
    path.unlink()
    assert client.get("/maps", headers=bearer(made["reader"])).status_code == 401


def test_who_guesses_tokens_waits_and_who_has_one_does_not(serve: Serve, tokens: tuple[Path, dict[str, str]]) -> None:
    path, made = tokens
    client = serve(tokens=path, refusals_a_minute=5)
    answers = [client.get("/maps", headers=bearer(f"lps_{number}")).status_code for number in range(8)]
    assert answers == [401] * 5 + [429] * 3
    assert client.get("/maps", headers=bearer(made["reader"])).status_code == 200


def test_a_flood_is_told_to_come_back(serve: Serve) -> None:
    client = serve(rate=1.0, burst=5.0)
    answers = [client.get("/maps") for _ in range(9)]
    assert [each.status_code for each in answers] == [200] * 5 + [429] * 4
    assert int(answers[-1].headers["retry-after"]) >= 1


def test_more_questions_than_may_wait_are_told_to_come_back(serve: Serve, model: Any) -> None:
    from lpslam.serving.answerers import ThreadAnswerer

    client = serve(answerer=ThreadAnswerer(model, 400, 0))
    refused = client.post("/ask", json={"question": "pizza"})
    assert (refused.status_code, refused.headers["retry-after"]) == (503, "1")
    assert client.get("/maps").status_code == 200


HOME = "http://127.0.0.1:8765"


def test_the_page_of_a_map_stands_beside_the_api(mall: Path, model: OfflineModel, tmp_path: Path) -> None:
    with TestClient(assemble([mall], Config(), model, "127.0.0.1", None, None, (), 0), base_url=HOME) as client:
        page = client.get("/")
        assert page.headers["content-type"].startswith("text/html")
        rules = page.headers["content-security-policy"]
        assert "default-src 'none'" in rules
        assert "connect-src 'self'" in rules
        assert "frame-ancestors 'none'" in rules
        name = client.get("/maps").json()["maps"][0]["name"]
        assert client.get(f"/page/{name}").text == page.text
        assert client.get("/page/nothing").status_code == 404
    # A browser cannot give a token with its first request.
    add_token(tmp_path / "tokens.json", "robot", ["read"], 1.0)
    tokens = Tokens(tmp_path / "tokens.json")
    with TestClient(assemble([mall], Config(), model, "127.0.0.1", tokens, None, (), 0), base_url=HOME) as client:
        assert client.get("/").status_code == 401
