"""Any chat model behind an OpenAI-compatible endpoint, held to the ids and names it was given.

The paper's “pre-training” (Figs. 3, 6 and 8), a task with examples, is one file a use in `prompts/`. What was read in
the world goes into the user message alone, JSON-encoded in its own field. An answer that is not allowed is asked for
once more; after that, and where the endpoint fails, the embedded model answers and the answer says so.
"""

import json
import math
from collections.abc import Callable, Mapping, Sequence
from importlib.resources import files
from typing import Any, TypeVar

from rapidfuzz.distance import Levenshtein

from lpslam.config import LanguageConfig
from lpslam.language.endpoint import Chat, Endpoint, NoAnswerError
from lpslam.language.model import Candidate, Choice, Judgement, LanguageModel, Naming, Reading
from lpslam.language.sanitise import clean_text

Answer = TypeVar("Answer")

_TEXT = {"type": "string"}
_SURE = {"confidence": {"type": "number"}, "evidence": _TEXT}


class ChatModel:
    """A `LanguageModel` over a chat endpoint, with another model to fall back on."""

    def __init__(self, endpoint: Endpoint, fallback: LanguageModel, config: LanguageConfig | None = None) -> None:
        self._config = config or LanguageConfig()
        self._chat = Chat(endpoint, self._config)
        self._fallback = fallback

    @property
    def model(self) -> str:
        """The specification this model was made from, such as "openai:gpt-4.1-mini"."""
        return self._chat.endpoint.label

    def name(self, readings: Sequence[Reading]) -> Naming:
        """Ask for the most reasonable name; one that is far from every reading is refused (III-E)."""
        texts = [clean_text(reading.text) for reading in readings]
        sent = [
            {"text": text, "count": reading.count, "confidence": round(reading.confidence, 3)}
            for text, reading in zip(texts, readings, strict=True)
            if text
        ]
        if not sent:
            return self._fallback.name(readings)

        def read(tree: Mapping[str, Any]) -> Naming:
            name = clean_text(str(tree["name"]))
            nearness = max(Levenshtein.normalized_similarity(name.casefold(), text.casefold()) for text in texts)
            if not name or nearness < self._config.name_similarity:
                raise ValueError("the name is close to none of the readings")
            return Naming(name, *_sureness(tree), self.model)

        schema = _object({"name": _TEXT, **_SURE})
        answer, failure = self._ask("naming", {"readings": sent}, schema, read)
        if answer is not None:
            return answer
        own = self._fallback.name(readings)
        return Naming(own.name, own.confidence, self._because(own.evidence, failure), self._instead(own.model))

    def judge(self, names: Sequence[str], question: str) -> list[Judgement]:
        """Ask the question for each name apart, some dozens of names at a time (III-G)."""
        judgements: list[Judgement] = []
        for start in range(0, len(names), self._config.names_per_call):
            judgements += self._judge(names[start : start + self._config.names_per_call], question)
        return judgements

    def _judge(self, names: Sequence[str], question: str) -> list[Judgement]:
        ids = list(range(len(names)))

        def read(tree: Mapping[str, Any]) -> list[Judgement]:
            by_id = {_an_id(answer["id"], ids): answer for answer in tree["answers"]}
            if len(by_id) != len(names) or len(tree["answers"]) != len(names):
                raise ValueError("not every name has one answer")
            return [
                Judgement(question, _a_bool(by_id[id_]["answer"]), *_sureness(by_id[id_]), self.model) for id_ in ids
            ]

        entry = _object({"id": {"type": "integer", "enum": ids}, "answer": {"type": "boolean"}, **_SURE})
        sent = {
            "question": clean_text(question, self._config.question_length),
            "names": [{"id": id_, "text": clean_text(name)} for id_, name in enumerate(names)],
        }
        schema = _object({"answers": {"type": "array", "items": entry}})
        answer, failure = self._ask("judging", sent, schema, read)
        if answer is not None:
            return answer
        return [
            Judgement(
                question, own.answer, own.confidence, self._because(own.evidence, failure), self._instead(own.model)
            )
            for own in self._fallback.judge(names, question)
        ]

    def choose(self, question: str, landmarks: Sequence[Candidate]) -> Choice:
        """Ask for the landmark that serves the wish; an id that was not given is refused (III-I)."""
        ids = [landmark.id for landmark in landmarks]
        if not ids:
            return Choice(None, 1.0, "the map has no landmark", self.model)

        def read(tree: Mapping[str, Any]) -> Choice:
            chosen = None if tree["landmark"] is None else _an_id(tree["landmark"], ids)
            others = [_an_id(other, ids) for other in tree.get("alternatives") or []]
            alternatives = tuple(other for other in dict.fromkeys(others) if other != chosen)
            confidence, evidence = _sureness(tree)
            return Choice(chosen, confidence, evidence, self.model, alternatives)

        one = {"type": "integer", "enum": ids}
        sent = {
            "question": clean_text(question, self._config.question_length),
            "landmarks": [
                {
                    "id": mark.id,
                    "name": clean_text(mark.name),
                    "aliases": [clean_text(alias) for alias in mark.aliases[: self._config.aliases_sent]],
                }
                for mark in landmarks
            ],
        }
        schema = _object(
            {"landmark": {"anyOf": [one, {"type": "null"}]}, "alternatives": {"type": "array", "items": one}, **_SURE}
        )
        answer, failure = self._ask("choosing", sent, schema, read)
        if answer is not None:
            return answer
        own = self._fallback.choose(question, landmarks)
        evidence = self._because(own.evidence, failure)
        return Choice(own.landmark, own.confidence, evidence, self._instead(own.model), own.alternatives)

    def _ask(
        self, use: str, sent: Mapping[str, Any], schema: Mapping[str, Any], read: Callable[[Mapping[str, Any]], Answer]
    ) -> tuple[Answer | None, str]:
        """Return the answer as `read` accepts it, or None and why there is none; asks a second time at most."""
        system = (files("lpslam.language") / "prompts" / f"{use}.md").read_text(encoding="utf-8")
        user = json.dumps(sent, ensure_ascii=False)
        failure = ""
        for _ in range(2):
            try:
                return read(_object_in(self._chat.complete(system, user, schema))), ""
            except NoAnswerError as error:
                return None, str(error)
            except (ValueError, KeyError, TypeError, AttributeError) as error:
                failure = f"its answer was refused: {error}"
        return None, failure

    def _because(self, evidence: str, failure: str) -> str:
        return f"{evidence} [{self.model} did not answer: {clean_text(failure)}]"

    def _instead(self, model: str) -> str:
        return f"{model} (instead of {self.model})"


def _object(properties: Mapping[str, Any]) -> dict[str, Any]:
    """A JSON schema of an object with exactly these properties."""
    return {
        "type": "object",
        "properties": dict(properties),
        "required": list(properties),
        "additionalProperties": False,
    }


def _object_in(text: str) -> Mapping[str, Any]:
    """Read the JSON object in an answer; models without a schema like to wrap it in words or a code fence."""
    start, end = text.find("{"), text.rfind("}")
    if start < 0 or end < start:
        raise ValueError("no JSON object in it")
    tree = json.loads(text[start : end + 1])
    if not isinstance(tree, dict):
        raise ValueError("no JSON object in it")
    return tree


def _an_id(value: Any, ids: Sequence[int]) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or value not in ids:
        raise ValueError(f"id {clean_text(str(value), 20)} was not given")
    return value


def _a_bool(value: Any) -> bool:
    if not isinstance(value, bool):
        raise ValueError("an answer is neither true nor false")
    return value


def _sureness(tree: Mapping[str, Any]) -> tuple[float, str]:
    """Confidence in 0..1 and evidence in one short line, whatever the model made of them."""
    confidence = float(tree.get("confidence", 0.5))
    if math.isnan(confidence):
        confidence = 0.5
    return min(max(confidence, 0.0), 1.0), clean_text(str(tree.get("evidence", "")), 300)
