"""A thousand landmarks are named and judged in few calls, and no sign decides about another."""

from collections.abc import Callable

from chat_server import ChatServer, Json, Reply, completion, fails, given

from lpslam.config import LanguageConfig
from lpslam.language.hosted.chat import ChatModel
from lpslam.language.hosted.endpoint import Endpoint
from lpslam.language.model import NamesTogether, Reading
from lpslam.language.offline import OfflineModel

Serve = Callable[..., ChatServer]
SHOPS = 1000


def model_at(server: ChatServer, **options: object) -> ChatModel:
    config = LanguageConfig(cache=False, backoff_s=0.0, **options)  # type: ignore[arg-type]
    return ChatModel(Endpoint("openai", server.url, "test", "test"), OfflineModel(), config)


def knows(tree: Json) -> Json:
    """A model that names by the commonest reading, and holds what has “Shop” in it for a shop."""
    sure = {"confidence": 0.9, "evidence": "as it is read"}
    if "signs" in tree and "question" in tree:
        found = [{"sign": each["sign"], "answer": "Shop" in each["text"], "confidence": 0.9} for each in tree["signs"]]
        return {"judgements": found}
    if "signs" in tree:
        most = [(each["sign"], max(each["readings"], key=lambda one: one["count"])) for each in tree["signs"]]
        return {"names": [{"sign": sign, "name": best["text"], "confidence": 0.9} for sign, best in most]}
    if "sign" in tree:
        return {"answer": "Shop" in tree["sign"], **sure}
    return {"name": max(tree["readings"], key=lambda one: one["count"])["text"], **sure}


def counted(body: Json) -> Reply:
    """Answers without saying how many tokens that took: they are counted by the letter, three to a token."""
    return Reply(200, completion(knows(given(body)), None))


def readings(number: int) -> list[Reading]:
    name = f"Atelier Vossberg Shop {number}"
    if number % 4 == 0:
        return [Reading(name, 6, 0.9)]
    return [Reading(name, 5, 0.9), Reading(name.replace("o", "0"), 2, 0.6), Reading(name[2:], 1, 0.5)]


def test_a_thousand_landmarks_take_at_most_120_calls_and_200_000_tokens(serve: Serve) -> None:
    model = model_at(serve(counted))
    assert isinstance(model, NamesTogether)
    names = model.name_all([readings(number) for number in range(SHOPS)])
    assert [each.name for each in names] == [f"Atelier Vossberg Shop {number}" for number in range(SHOPS)]
    judged = model.judge([each.name for each in names], "Is this a shop?")
    assert all(each.answer for each in judged)
    assert model.usage.calls <= 120
    assert model.usage.tokens <= 200_000


def test_what_was_always_read_alike_is_not_asked(serve: Serve) -> None:
    server = serve(counted)
    names = model_at(server).name_all([[Reading("Zara", 6, 0.9)], [Reading("ZARA", 2, 0.9), Reading("Zara", 4, 0.9)]])
    assert [each.name.casefold() for each in names] == ["zara", "zara"]
    assert not server.requests


def test_a_sign_that_sways_the_others_is_found_out(serve: Serve) -> None:
    def swayed(body: Json) -> Reply:
        tree = given(body)
        if "signs" in tree and tree["signs"][0]["text"].startswith("Ghost"):
            no = [{"sign": each["sign"], "answer": False, "confidence": 0.9} for each in tree["signs"]]
            return Reply(200, completion({"judgements": no}))
        return counted(body)

    shops = ["Ghost Alley", *(f"Shoe Shop {number}" for number in range(40))]
    judged = model_at(serve(swayed), signs_together=20).judge(shops, "Is this a shop?")
    assert [name for name, each in zip(shops, judged, strict=True) if not each.answer] == ["Ghost Alley"]


def test_a_server_that_is_busy_for_a_while_does_not_send_the_rest_offline(serve: Serve) -> None:
    server = serve(counted, *[fails(503)] * 8, counted)
    model = model_at(server, signs_together=2, attempts=1, rest_s=0.05)
    names = model.name_all([readings(4 * number + 1) for number in range(20)])
    assert {each.model for each in names} == {f"{model.model}"}


def test_an_answer_about_a_sign_that_was_not_given_is_refused(serve: Serve) -> None:
    def invents(body: Json) -> Reply:
        return Reply(200, completion({"judgements": [{"sign": 99, "answer": True, "confidence": 1.0}]}))

    judged = model_at(serve(invents), signs_together=2).judge(["KFC", "STOP", "Zara"], "Is this a shop?")
    assert [each.answer for each in judged] == [True, False, True]
    assert all("instead of" in each.model for each in judged)
