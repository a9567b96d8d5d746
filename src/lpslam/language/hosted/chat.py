"""Any hosted or local chat model, held to the ids and names it was given.

The paper's “pre-training” (Figs. 3, 6 and 8), a task with examples, is one file a use in `prompts/`. What was read in
the world goes into the user message alone, JSON-encoded in a field of its own, and only where it does not read like a
command (`distrust.py`). Few names are judged each in a request of its own, many in requests of several, and what the
embedded model sees otherwise once more in another order. A choice among
many names is taken where the embedded model agrees, or where the model says the same of that place alone. An answer
that is not allowed is asked for once more; after that, and where the model fails, the embedded one answers and says so.
"""

import random
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any, TypeVar

from rapidfuzz.distance import Levenshtein

from lpslam.config import LanguageConfig
from lpslam.language.hosted.answers import (
    EVIDENCE_LENGTH,
    NONE,
    SURE,
    TEXT,
    Labels,
    a_bool,
    numbered,
    object_of,
    parts_of,
    sureness,
    task,
)
from lpslam.language.hosted.endpoint import Endpoint
from lpslam.language.hosted.exchange import Exchange, NoAnswerError, Question
from lpslam.language.hosted.shortlist import shortlist
from lpslam.language.hosted.usage import AnswerCache, Usage
from lpslam.language.kept import user_cache_folder
from lpslam.language.model import Candidate, Choice, Judgement, LanguageModel, Naming, Reading
from lpslam.language.sanitise import clean_text
from lpslam.language.signs.distrust import choose_trusted, commands, is_sentence
from lpslam.language.signs.reader import load_sign_reader
from lpslam.language.tables.knowledge import load_knowledge

Given = TypeVar("Given", Naming, Judgement, Choice)

_UNTRUSTED = "it was not asked: the sign reads like a command"
_MOST_LISTED = 200  # ids that a schema lists; servers take few hundred, and the answer is checked in any case
_REMEMBERED = 6  # questions and answers of a dialogue that are sent along
_SEARCHED = 8  # kinds and names that a model may say would serve
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
        sent = self._sent(readings)
        if not sent:
            return own
        if any(commands(reading.text) for reading in readings):
            return self._instead(own, _UNTRUSTED)
        schema = object_of({"name": TEXT, **SURE})
        question = Question(
            task("naming"), {"readings": sent}, schema, lambda tree: self._name_of(tree, str(tree["name"]), readings)
        )
        (answer,) = self._exchange.ask([question])
        return self._instead(own, str(answer)) if isinstance(answer, NoAnswerError) else answer

    def name_all(self, groups: Sequence[Sequence[Reading]]) -> list[Naming]:
        """Name many classes, some in one request; what was always read alike is not asked (III-E)."""
        named = [self._embedded.name(readings) for readings in groups]
        wanting = [at for at, readings in enumerate(groups) if self._is_unsure(readings)]
        for at in sorted(set(range(len(groups))) - set(wanting)):
            if any(commands(reading.text) for reading in groups[at]):
                named[at] = self._instead(named[at], _UNTRUSTED)
            else:
                named[at] = replace(named[at], evidence="it was always read alike", model=self.model)
        parts = parts_of(wanting, self._config.signs_together)
        answers = self._exchange.ask([self._naming_of(part, groups) for part in parts])
        for part, answer in zip(parts, answers, strict=True):
            for at in part:
                name = None if isinstance(answer, NoAnswerError) else answer.get(at)
                why = str(answer) if isinstance(answer, NoAnswerError) else "its name is close to none of the readings"
                named[at] = name or self._instead(named[at], why)
        return named

    def _is_unsure(self, readings: Sequence[Reading]) -> bool:
        """Whether a class was read in more ways than one, and may be shown."""
        texts = {clean_text(reading.text).casefold() for reading in readings} - {""}
        return len(texts) > 1 and not any(commands(reading.text) for reading in readings)

    def _naming_of(self, part: Sequence[int], groups: Sequence[Sequence[Reading]]) -> Question[dict[int, Naming]]:
        """One request for the names of several classes; a name that is far from its readings is left out."""

        def read(tree: Mapping[str, Any]) -> dict[int, Naming]:
            found: dict[int, Naming] = {}
            for each in tree["names"]:
                at = numbered(each, part)
                with suppress(ValueError):
                    found[at] = self._name_of(each, str(each["name"]), groups[at])
            return found

        signs = [{"sign": number, "readings": self._sent(groups[at])} for number, at in enumerate(part, 1)]
        one = object_of({"sign": {"type": "integer"}, "name": TEXT, "confidence": {"type": "number"}})
        schema = object_of({"names": {"type": "array", "items": one}})
        return Question(task("naming_many"), {"signs": signs}, schema, read)

    def _sent(self, readings: Sequence[Reading]) -> list[dict[str, Any]]:
        return [
            {
                "text": text,
                "count": reading.count,
                "confidence": round(reading.confidence if reading.right is None else reading.right, 3),
            }
            for reading in readings[: self._config.readings_sent]
            if (text := clean_text(reading.text))
        ]

    def _name_of(self, tree: Mapping[str, Any], said: str, readings: Sequence[Reading]) -> Naming:
        name = clean_text(said)
        texts = [clean_text(reading.text).casefold() for reading in readings]
        nearness = max(Levenshtein.normalized_similarity(name.casefold(), text) for text in texts)
        if not name or nearness < self._config.name_similarity:
            raise ValueError("the name is close to none of the readings")
        return Naming(name, *sureness(tree), self.model)

    def judge(self, names: Sequence[str], question: str) -> list[Judgement]:
        """Ask the question for each name: few in a request each, many in requests of several (III-G)."""
        asked = clean_text(question, self._config.question_length)
        trusted = [name for name in dict.fromkeys(names) if clean_text(name) and commands(name) is None]
        few = len(trusted) <= self._config.signs_together
        answers = self._judged_alone(trusted, asked) if few else self._judged_together(trusted, asked)
        untrusted = NoAnswerError(_UNTRUSTED)
        failed = {name: answer for name in names if isinstance(answer := answers.get(name, untrusted), NoAnswerError)}
        own = dict(zip(failed, self._embedded.judge(list(failed), question), strict=True))
        judged = {name: self._instead(own[name], str(failure)) for name, failure in failed.items()}
        judged |= {
            name: replace(each, question=question) for name, each in answers.items() if isinstance(each, Judgement)
        }
        return [judged[name] for name in names]

    def _judged_alone(self, names: Sequence[str], asked: str) -> dict[str, Judgement | NoAnswerError]:
        """Each name in a request of its own, so that none can sway another."""
        schema = object_of({"answer": {"type": "boolean"}, **SURE})

        def read(tree: Mapping[str, Any]) -> Judgement:
            return Judgement(asked, a_bool(tree["answer"]), *sureness(tree), self.model)

        questions = [
            Question(task("judging"), {"question": asked, "sign": clean_text(name)}, schema, read) for name in names
        ]
        answers = self._exchange.ask(questions)
        return dict(zip(names, answers, strict=True))

    def _judged_together(self, names: Sequence[str], asked: str) -> dict[str, Judgement | NoAnswerError]:
        """Several names in a request; where the embedded model says otherwise, once more among others in another order.

        What two orders answer differently is asked alone: there no other sign is read.
        """
        first = self._judged_in_parts(names, asked)
        own = dict(zip(names, self._embedded.judge(names, asked), strict=True))
        doubtful = [
            name
            for name, answer in first.items()
            if isinstance(answer, Judgement) and answer.answer != own[name].answer and own[name].confidence > 0.0
        ]
        random.Random(len(doubtful)).shuffle(doubtful)
        again = self._judged_in_parts(doubtful, asked)
        torn = [name for name in doubtful if _says(again[name]) != _says(first[name])]
        return first | self._judged_alone(torn, asked)

    def _judged_in_parts(self, names: Sequence[str], asked: str) -> dict[str, Judgement | NoAnswerError]:
        one = object_of({"sign": {"type": "integer"}, "answer": {"type": "boolean"}, "confidence": {"type": "number"}})
        schema = object_of({"judgements": {"type": "array", "items": one}})
        parts = parts_of(range(len(names)), self._config.signs_together)

        def question(part: Sequence[int]) -> Question[dict[int, Judgement]]:
            def read(tree: Mapping[str, Any]) -> dict[int, Judgement]:
                return {
                    numbered(each, part): Judgement(asked, a_bool(each["answer"]), *sureness(each), self.model)
                    for each in tree["judgements"]
                }

            signs = [{"sign": number, "text": clean_text(names[at])} for number, at in enumerate(part, 1)]
            return Question(task("judging_many"), {"question": asked, "signs": signs}, schema, read)

        judged: dict[str, Judgement | NoAnswerError] = {}
        answers = self._exchange.ask([question(part) for part in parts])
        for part, answer in zip(parts, answers, strict=True):
            for at in part:
                left_out = NoAnswerError("it left this sign out")
                judged[names[at]] = answer if isinstance(answer, NoAnswerError) else answer.get(at, left_out)
        return judged

    def choose(self, question: str, landmarks: Sequence[Candidate]) -> Choice:
        """Ask for the landmark that serves the wish, and look at the answer once more in another way (III-I)."""
        return self.choose_after((), question, landmarks)

    def choose_after(self, history: Sequence[tuple[str, str]], question: str, landmarks: Sequence[Candidate]) -> Choice:
        """As `choose`, after what was asked and answered before, (question, answer), the oldest first."""
        asked = clean_text(question, self._config.question_length)
        if not landmarks:
            return Choice(None, 1.0, "the map has no landmark", self.model)
        if not asked:
            return Choice(None, 0.0, "the question is empty", self.model)
        own = choose_trusted(self._embedded, asked, landmarks)
        shown = [mark for mark in landmarks if _may_be_shown(mark.name)]
        if not shown:
            return self._instead(own, "it was not asked: no sign here names a place")
        if len(shown) > self._config.landmarks_sent:
            shown = self._found(asked, shown, own)
        before = [
            {"question": clean_text(said, self._config.question_length), "answer": clean_text(answer)}
            for said, answer in history[-_REMEMBERED:]
        ]
        first = self._choose(asked, shown, before)
        if isinstance(first, NoAnswerError):
            return self._instead(own, str(first))
        return self._look_again(asked, first, own, {mark.id: mark for mark in landmarks}, before)

    def _found(self, asked: str, landmarks: Sequence[Candidate], own: Choice) -> list[Candidate]:
        """Of more landmarks than may be sent, those that fit the question and what the model says would serve it."""

        def read(tree: Mapping[str, Any]) -> list[str]:
            return [clean_text(str(text), self._config.name_length) for text in tree["serves"]][:_SEARCHED]

        schema = object_of({"serves": {"type": "array", "items": TEXT}})
        (said,) = self._exchange.ask([Question(task("searching"), {"question": asked}, schema, read)])
        each = self._config.landmarks_found
        found = shortlist(asked, landmarks, each, own)
        for text in () if isinstance(said, NoAnswerError) else filter(None, said):
            found += shortlist(
                text, landmarks, max(1, each // _SEARCHED), choose_trusted(self._embedded, text, landmarks)
            )
        ids = {mark.id for mark in found}
        return [mark for mark in landmarks if mark.id in ids][: self._config.landmarks_sent]

    def _choose(
        self, asked: str, shown: Sequence[Candidate], before: Sequence[Mapping[str, str]] = ()
    ) -> Choice | NoAnswerError:
        labels = Labels(shown)

        def read(tree: Mapping[str, Any]) -> Choice:
            chosen = labels.landmark(tree["landmark"])
            others = [labels.landmark(other) for other in tree.get("alternatives") or []]
            alternatives = tuple(dict.fromkeys(other for other in others if other not in (chosen, None)))
            confidence, evidence = sureness(tree)
            return Choice(chosen, confidence, labels.told(evidence), self.model, alternatives)

        few = len(labels.all) <= _MOST_LISTED
        ids = {"type": "string", "enum": [*labels.all, NONE]} if few else TEXT
        # Evidence first: a model that has to say why before it says which thinks before it answers.
        schema = object_of({"evidence": TEXT, "landmark": ids, "alternatives": {"type": "array", "items": ids}} | SURE)
        # What stays the same from question to question stands first, so that a server keeps what it has read of it.
        given: dict[str, Any] = {"landmarks": [{"id": label, **self._place(mark)} for label, mark in labels.shown]}
        given |= {"before": list(before)} if before else {}
        given["question"] = asked
        return self._exchange.ask([Question(task("choosing"), given, schema, read)])[0]

    def _look_again(
        self,
        asked: str,
        first: Choice,
        own: Choice,
        by_id: Mapping[int, Candidate],
        before: Sequence[Mapping[str, str]],
    ) -> Choice:
        """Take what two models chose; else ask about each of the two alone, where no other sign is read.

        What swayed the choice among many (a sign that the rules of `distrust.py` missed) cannot sway this; and a sign
        that speaks for itself comes second to a place that is known for what it is. In a dialogue the embedded model
        has not heard what was said before: it proposes nothing then.
        """
        proposed = [by_id[id_] for id_ in (first.landmark, None if before else own.landmark) if id_ is not None]
        if first.landmark == own.landmark or (len(proposed) == 2 and _is_same(*proposed)):
            return first
        reader = load_sign_reader()
        # A sign that is known for a place and says little else goes first.
        proposed.sort(
            key=lambda mark: is_sentence(mark.name, _FEW_WORDS, _FEW_UNSPACED) or not reader.read(mark.name).is_place
        )
        refused = first.evidence
        for landmark in proposed:
            serves = self._serves(asked, landmark, before)
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

    def _serves(
        self, asked: str, landmark: Candidate, before: Sequence[Mapping[str, str]]
    ) -> Judgement | NoAnswerError:
        def read(tree: Mapping[str, Any]) -> Judgement:
            return Judgement(asked, a_bool(tree["serves"]), *sureness(tree), self.model)

        schema = object_of({"serves": {"type": "boolean"}, **SURE})
        given: dict[str, Any] = {"question": asked, "place": self._place(landmark)}
        # Answers are names of signs: none that speaks to a machine is read with the place.
        heard = [each for each in before if commands(each["answer"]) is None]
        given |= {"before": heard} if heard else {}
        return self._exchange.ask([Question(task("confirming"), given, schema, read)])[0]

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
        evidence = f"{own.evidence} [{self.model} did not answer: {clean_text(failure, EVIDENCE_LENGTH)}]"
        return replace(own, evidence=evidence, model=f"{own.model} (instead of {self.model})")


def _may_be_shown(name: str) -> bool:
    """Whether a sign may stand among others in a prompt: it names a place, and neither commands nor warns.

    What a door says of who may enter (STAFF ONLY) warns, and is a place all the same.
    """
    if not clean_text(name) or commands(name) is not None or is_sentence(name):
        return False
    knowledge = load_knowledge()
    warns = any(kind == "sign/warning" for kind, _ in load_sign_reader().read(name).kinds)
    return not warns or knowledge.folder.key(clean_text(name)) in knowledge.doors


def _is_same(first: Candidate, second: Candidate) -> bool:
    return clean_text(first.name).casefold() == clean_text(second.name).casefold()


def _says(answer: Judgement | NoAnswerError) -> bool | None:
    return answer.answer if isinstance(answer, Judgement) else None
