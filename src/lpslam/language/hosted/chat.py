"""Any hosted or local chat model, held to the ids and names it was given.

The paper's “pre-training” (Figs. 3, 6 and 8), a task with examples, is one file a use in `prompts/`. What was read in
the world goes into the user message alone, JSON-encoded in a field of its own, and only where it does not read like a
command (`distrust.py`). Names are judged each in a request of its own, so that none can sway another. A choice among
many names is taken where the embedded model agrees, or where the model says the same of that place alone. An answer
that is not allowed is asked for once more; after that, and where the model fails, the embedded one answers and says so.
"""

import hashlib
import json
import math
import random
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from importlib.resources import files
from typing import Any, TypeVar

from rapidfuzz.distance import Levenshtein

from lpslam.config import LanguageConfig
from lpslam.language.hosted.answer_cache import AnswerCache, user_cache_folder
from lpslam.language.hosted.endpoint import Endpoint
from lpslam.language.hosted.exchange import Exchange, NoAnswerError, Question
from lpslam.language.hosted.shortlist import shortlist
from lpslam.language.hosted.usage import Usage
from lpslam.language.model import Candidate, Choice, Judgement, LanguageModel, Naming, Reading
from lpslam.language.sanitise import clean_text
from lpslam.language.signs.distrust import choose_trusted, commands, is_sentence
from lpslam.language.signs.reader import load_sign_reader

Given = TypeVar("Given", Naming, Judgement, Choice)

_NONE = "none"
_LABEL = re.compile(r"\bL\d{4}\b")
_TEXT = {"type": "string"}
_SURE = {"confidence": {"type": "number"}, "evidence": _TEXT}
_EVIDENCE_LENGTH = 300
_FEW_WORDS, _FEW_UNSPACED = 3, 8  # letters of a script without spaces; a sign of a known place seldom says more


class ChatModel:
    """A `LanguageModel` over a chat endpoint, with the embedded model beside it."""

    def __init__(self, endpoint: Endpoint, embedded: LanguageModel, config: LanguageConfig | None = None) -> None:
        self._config = config or LanguageConfig()
        folder = user_cache_folder() if self._config.cache else None
        cache = AnswerCache(folder / "answers" if folder else None)
        self._exchange = Exchange(endpoint, self._config, cache)
        self._embedded = embedded

    @property
    def model(self) -> str:
        """The specification this model was made from, such as "openai:gpt-4.1-mini"."""
        return self._exchange.endpoint.label

    @property
    def usage(self) -> Usage:
        """Calls and tokens so far."""
        return self._exchange.usage

    def name(self, readings: Sequence[Reading]) -> Naming:
        """Ask for the most reasonable name; one that is far from every reading is refused (III-E)."""
        own = self._embedded.name(readings)
        sent = [
            {
                "text": text,
                "count": reading.count,
                "confidence": round(reading.confidence if reading.right is None else reading.right, 3),
            }
            for reading in readings[: self._config.readings_sent]
            if (text := clean_text(reading.text))
        ]
        if not sent:
            return own
        if any(commands(reading.text) for reading in readings):
            return self._instead(own, "it was not asked: the sign reads like a command")
        texts = [clean_text(reading.text) for reading in readings]

        def read(tree: Mapping[str, Any]) -> Naming:
            name = clean_text(str(tree["name"]))
            nearness = max(Levenshtein.normalized_similarity(name.casefold(), text.casefold()) for text in texts)
            if not name or nearness < self._config.name_similarity:
                raise ValueError("the name is close to none of the readings")
            return Naming(name, *_sureness(tree), self.model)

        schema = _object({"name": _TEXT, **_SURE})
        (answer,) = self._exchange.ask([Question(_task("naming"), {"readings": sent}, schema, read)])
        return self._instead(own, str(answer)) if isinstance(answer, NoAnswerError) else answer

    def judge(self, names: Sequence[str], question: str) -> list[Judgement]:
        """Ask the question for each name in a request of its own, a few of them at the same time (III-G)."""
        asked = clean_text(question, self._config.question_length)
        schema = _object({"answer": {"type": "boolean"}, **_SURE})

        def read(tree: Mapping[str, Any]) -> Judgement:
            return Judgement(question, _a_bool(tree["answer"]), *_sureness(tree), self.model)

        trusted = [name for name in dict.fromkeys(names) if clean_text(name) and commands(name) is None]
        answers = dict(
            zip(
                trusted,
                self._exchange.ask(
                    [
                        Question(_task("judging"), {"question": asked, "sign": clean_text(name)}, schema, read)
                        for name in trusted
                    ]
                ),
                strict=True,
            )
        )
        untrusted = NoAnswerError("it was not asked: the sign reads like a command")
        failed = {name: answer for name in names if isinstance(answer := answers.get(name, untrusted), NoAnswerError)}
        own = dict(zip(failed, self._embedded.judge(list(failed), question), strict=True))
        judged = {name: self._instead(own[name], str(failure)) for name, failure in failed.items()}
        judged |= {name: answer for name, answer in answers.items() if isinstance(answer, Judgement)}
        return [judged[name] for name in names]

    def choose(self, question: str, landmarks: Sequence[Candidate]) -> Choice:
        """Ask for the landmark that serves the wish, and look at the answer once more in another way (III-I)."""
        asked = clean_text(question, self._config.question_length)
        if not landmarks:
            return Choice(None, 1.0, "the map has no landmark", self.model)
        if not asked:
            return Choice(None, 0.0, "the question is empty", self.model)
        own = choose_trusted(self._embedded, asked, landmarks)
        nearest = shortlist(asked, landmarks, self._config.landmarks_sent, own)
        shown = [mark for mark in nearest if _may_be_shown(mark.name)]
        if not shown:
            return self._instead(own, "it was not asked: no sign here names a place")
        first = self._choose(asked, shown)
        if isinstance(first, NoAnswerError):
            return self._instead(own, str(first))
        return self._look_again(asked, first, own, {mark.id: mark for mark in landmarks})

    def _choose(self, asked: str, shown: Sequence[Candidate]) -> Choice | NoAnswerError:
        labels = _Labels(asked, shown)

        def read(tree: Mapping[str, Any]) -> Choice:
            chosen = labels.landmark(tree["landmark"])
            others = [labels.landmark(other) for other in tree.get("alternatives") or []]
            alternatives = tuple(dict.fromkeys(other for other in others if other not in (chosen, None)))
            confidence, evidence = _sureness(tree)
            return Choice(chosen, confidence, labels.told(evidence), self.model, alternatives)

        ids = {"type": "string", "enum": [*labels.all, _NONE]}
        schema = _object({"landmark": ids, "alternatives": {"type": "array", "items": ids}, **_SURE})
        places = [{"id": label, **self._place(mark)} for label, mark in labels.shown]
        given = {"question": asked, "landmarks": places}
        return self._exchange.ask([Question(_task("choosing"), given, schema, read)])[0]

    def _look_again(self, asked: str, first: Choice, own: Choice, by_id: Mapping[int, Candidate]) -> Choice:
        """Take what two models chose; else ask about each of the two alone, where no other sign is read.

        What swayed the choice among many (a sign that the rules of `distrust.py` missed) cannot sway this; and a sign
        that speaks for itself comes second to a place that is known for what it is.
        """
        proposed = [by_id[id_] for id_ in (first.landmark, own.landmark) if id_ is not None]
        if first.landmark == own.landmark or (len(proposed) == 2 and _is_same(*proposed)):
            return first
        proposed.sort(key=lambda landmark: not _is_plainly_a_place(landmark.name))
        refused = first.evidence
        for landmark in proposed:
            serves = self._serves(asked, landmark)
            if isinstance(serves, NoAnswerError):
                return self._instead(own, str(serves))
            if serves.answer and landmark.id == first.landmark:
                return first
            if serves.answer:
                others = dict.fromkeys((*first.alternatives, *own.alternatives))
                rest = tuple(other for other in others if other != landmark.id)
                return Choice(landmark.id, serves.confidence, serves.evidence, self.model, rest)
            refused = serves.evidence
        return Choice(None, first.confidence, refused, self.model, first.alternatives)

    def _serves(self, asked: str, landmark: Candidate) -> Judgement | NoAnswerError:
        def read(tree: Mapping[str, Any]) -> Judgement:
            return Judgement(asked, _a_bool(tree["serves"]), *_sureness(tree), self.model)

        schema = _object({"serves": {"type": "boolean"}, **_SURE})
        given = {"question": asked, "place": self._place(landmark)}
        return self._exchange.ask([Question(_task("confirming"), given, schema, read)])[0]

    def _place(self, landmark: Candidate) -> dict[str, Any]:
        name, longest = landmark.name, self._config.name_length
        aliases = [
            clean_text(alias, longest)
            for alias in dict.fromkeys((*landmark.lines, *landmark.aliases))
            if alias != name and commands(alias) is None
        ][: self._config.aliases_sent]
        place: dict[str, Any] = {"name": clean_text(name, longest)}
        return {**place, "aliases": aliases} if aliases else place

    def _instead(self, own: Given, failure: str) -> Given:
        """The embedded model's answer, with the reason why it is that one's."""
        evidence = f"{own.evidence} [{self.model} did not answer: {clean_text(failure, _EVIDENCE_LENGTH)}]"
        return replace(own, evidence=evidence, model=f"{own.model} (instead of {self.model})")


class _Labels:
    """Names for landmarks that no sign can know: which label stands for which landmark hangs on the whole question.

    The labels themselves are always the same ones, so that a server need not learn a new schema for every question.
    """

    def __init__(self, asked: str, shown: Sequence[Candidate]) -> None:
        seed = hashlib.sha256(json.dumps([asked, [mark.name for mark in shown]]).encode()).digest()
        order = list(shown)
        random.Random(seed).shuffle(order)
        self.all = [f"L{1000 + number * 7919 % 9000}" for number in range(len(shown))]
        self.shown = list(zip(self.all, order, strict=True))
        self._by_label = dict(self.shown)

    def landmark(self, label: Any) -> int | None:
        """Take a label back to a landmark's id.

        Raises:
            ValueError: no landmark has it.
        """
        if label is None or label == _NONE:
            return None
        if not isinstance(label, str) or label not in self._by_label:
            raise ValueError(f"id {clean_text(str(label), 20)} was not given")
        return self._by_label[label].id

    def told(self, evidence: str) -> str:
        """Put names for the labels that an explanation mentions."""
        return _LABEL.sub(
            lambda found: self._by_label[found[0]].name if found[0] in self._by_label else found[0], evidence
        )


def _may_be_shown(name: str) -> bool:
    """Whether a sign may stand among others in a prompt: it names a place, and neither commands nor warns."""
    return bool(clean_text(name)) and commands(name) is None and not is_sentence(name) and not _warns(name)


def _is_plainly_a_place(name: str) -> bool:
    """Whether a sign is known for a place and says little else."""
    return load_sign_reader().read(name).is_place and not is_sentence(name, _FEW_WORDS, _FEW_UNSPACED)


def _warns(name: str) -> bool:
    return any(kind == "sign/warning" for kind, _ in load_sign_reader().read(name).kinds)


def _is_same(first: Candidate, second: Candidate) -> bool:
    return clean_text(first.name).casefold() == clean_text(second.name).casefold()


@lru_cache(maxsize=8)
def _task(use: str) -> str:
    """The task and its examples; the version line is for people, what counts for the cache is the wording."""
    text = (files("lpslam.language") / "prompts" / f"{use}.md").read_text(encoding="utf-8")
    return text.partition("\n\n")[2]


def _object(properties: Mapping[str, Any]) -> dict[str, Any]:
    """A JSON schema of an object with exactly these properties."""
    return {
        "type": "object",
        "properties": dict(properties),
        "required": list(properties),
        "additionalProperties": False,
    }


def _a_bool(value: Any) -> bool:
    if not isinstance(value, bool):
        raise ValueError("an answer is neither true nor false")
    return value


def _sureness(tree: Mapping[str, Any]) -> tuple[float, str]:
    """Confidence in 0..1 and evidence in one short line, whatever the model made of them."""
    confidence = float(tree.get("confidence", 0.5))
    if math.isnan(confidence):
        confidence = 0.5
    return min(max(confidence, 0.0), 1.0), clean_text(str(tree.get("evidence", "")), _EVIDENCE_LENGTH)
