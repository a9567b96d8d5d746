"""A person's corrections over HTTP and on the command line: kept in the file, one editor after the other."""

import json
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from served_here import Serve
from starlette.testclient import TestClient

from command_line import Command
from lpslam.mapfile.language_map import LanguageMap
from lpslam.serving.tokens import add_token
from small_maps import MALL


def names(path: Path) -> dict[int, str]:
    return {mark.id: mark.name for mark in LanguageMap.load(path).landmarks()}


def test_what_is_said_is_kept_in_the_file_and_asked_from_then_on(client: TestClient, mall: Path) -> None:
    version = client.get("/maps/mall").json()["version"]
    body = {"revision": 0, "kind": "rename", "landmark": 0, "name": "Zum goldenen Hirsch"}
    state = client.post("/corrections", json=body)
    assert state.status_code == 200, state.text
    assert state.json()["revision"] == 1
    assert state.json()["version"] != version
    assert names(mall)[0] == "Zum goldenen Hirsch"
    assert client.get("/landmarks/0").json()["corrections"][0]["read"] == MALL[0]
    assert "Hirsch" in client.post("/ask", json={"question": "Zum goldenen Hirsch"}).json()["text"]
    state = client.delete("/corrections/1", params={"revision": 1})
    assert (state.status_code, state.json()["corrections"]) == (200, [])
    assert names(mall)[0] == MALL[0]


def test_who_comes_second_is_shown_what_there_is(client: TestClient, mall: Path) -> None:
    body = {"revision": 0, "kind": "hide", "landmark": 0}
    assert client.post("/corrections", json=body).status_code == 200
    late = client.post("/corrections", json={**body, "landmark": 1000})
    assert late.status_code == 409
    assert late.headers["content-type"] == "application/problem+json"
    assert late.json()["revision"] == 1
    assert [each["landmark"] for each in late.json()["corrections"]] == [0]
    assert set(names(mall)) == {1000 * number for number in range(1, len(MALL))}


def test_of_many_at_once_one_is_first_and_nothing_is_lost(client: TestClient, mall: Path) -> None:
    def hide(landmark: int) -> int:
        return client.post("/corrections", json={"revision": 0, "kind": "hide", "landmark": landmark}).status_code

    with ThreadPoolExecutor(4) as pool:
        codes = sorted(pool.map(hide, [0, 1000, 2000, 3000]))
    assert codes == [200, 409, 409, 409]
    assert len(LanguageMap.load(mall).text.corrections.entries) == 1


def test_a_file_that_another_program_has_corrected_is_read_first(
    client: TestClient, mall: Path, lpslam: Command
) -> None:
    done = lpslam("correct", mall, 1000, "--name", "Pizzeria", "--json").json
    assert done["revision"] == 1
    late = client.post("/corrections", json={"revision": 0, "kind": "hide", "landmark": 0})
    assert late.status_code == 409
    body = {"revision": 1, "kind": "merge", "landmark": 0, "into": 1000}
    assert client.post("/corrections", json=body).status_code == 200
    assert names(mall)[1000] == "Pizzeria"
    assert 0 not in names(mall)


def test_names_are_text_and_what_makes_no_sense_is_refused(client: TestClient, mall: Path) -> None:
    hostile = "<img src=x onerror=alert(1)>\u202e"
    body = {"revision": 0, "kind": "rename", "landmark": 0, "name": hostile}
    assert client.post("/corrections", json=body).status_code == 200
    assert names(mall)[0] == "<img src=x onerror=alert(1)>"
    before = mall.read_bytes()
    for wrong, code in (
        ({**body, "revision": 1, "name": " "}, 422),
        ({**body, "revision": 1, "name": "\ud800"}, 422),
        ({**body, "revision": 1, "name": "x" * 500}, 422),
        ({**body, "revision": 1, "landmark": 77}, 404),
        ({**body, "revision": 1, "landmark": True}, 422),
        ({**body, "revision": 1, "kind": "delete"}, 422),
        ({**body, "revision": 1, "map": "../../etc/passwd"}, 404),
        ({**body, "revision": 1, "more": 1}, 422),
        ({"revision": 1, "kind": "judge", "landmark": 0, "answer": "yes"}, 422),
        ({"kind": "hide", "landmark": 0}, 422),
    ):
        answer = client.post(
            "/corrections", content=json.dumps(wrong).encode(), headers={"content-type": "application/json"}
        )
        assert answer.status_code == code, (wrong, answer.text)
    assert client.delete("/corrections/9", params={"revision": 1}).status_code == 404
    assert mall.read_bytes() == before


def test_a_page_of_another_origin_corrects_nothing(client: TestClient, mall: Path) -> None:
    before = mall.read_bytes()
    body = {"revision": 0, "kind": "hide", "landmark": 0}
    refused = client.post("/corrections", json=body, headers={"origin": "http://evil.example"})
    assert refused.status_code == 403
    assert mall.read_bytes() == before


def test_correcting_needs_a_scope_of_its_own(serve: Serve, tmp_path: Path) -> None:
    reader = add_token(tmp_path / "tokens.json", "reader", ["read", "ask"], 1.0)
    writer = add_token(tmp_path / "tokens.json", "writer", ["write"], 1.0)
    client = serve(tokens=tmp_path / "tokens.json")
    body = {"revision": 0, "kind": "hide", "landmark": 0}
    for token, code in ((reader, 403), (writer, 200)):
        answer = client.post("/corrections", json=body, headers={"authorization": f"Bearer {token}"})
        assert answer.status_code == code
    assert client.get("/corrections", headers={"authorization": f"Bearer {reader}"}).json()["revision"] == 1


def test_a_map_that_cannot_be_written_is_not_corrected(client: TestClient, mall: Path) -> None:
    mall.unlink()
    answer = client.post("/corrections", json={"revision": 0, "kind": "hide", "landmark": 0})
    assert answer.status_code == 422
    assert client.get("/landmarks/0").status_code == 200


def test_the_command_lists_and_takes_back_what_was_said(lpslam: Command, mall: Path) -> None:
    lpslam("correct", mall, 2000, "--judge", "no", "--name", "Bookshop")
    listed = lpslam("correct", mall, "--json").json["corrections"]
    assert [(each["number"], each["kind"]) for each in listed] == [(1, "rename"), (2, "judge")]
    assert "is called Bookshop" in lpslam("correct", mall).out
    lpslam("correct", mall, "--undo", 1)
    assert names(mall)[2000] == MALL[2]
    assert "no correction 1" in lpslam("correct", mall, "--undo", 1).complaint
    assert "no landmark 5" in lpslam("correct", mall, 5, "--hide").complaint
    assert "--name" in lpslam("correct", mall, 2000).complaint
    assert "id of a landmark" in lpslam("correct", mall, "--hide").complaint
