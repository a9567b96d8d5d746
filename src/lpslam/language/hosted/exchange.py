"""Questions to a hosted or local model: asked with patience, within a budget, and answered only as is allowed.

A question that fails gives a `NoAnswerError` with the reason; a mistake that the user can mend is raised.
"""

import asyncio
import json
import time
from collections.abc import Awaitable, Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from lpslam.config import LanguageConfig
from lpslam.errors import LpSlamError, MissingExtraError, UserError
from lpslam.language.hosted.endpoint import EXTRAS, Endpoint
from lpslam.language.hosted.usage import AnswerCache, Usage
from lpslam.language.sanitise import clean_text

if TYPE_CHECKING:
    from pydantic_ai.models import Model

    from lpslam.language.hosted.clients import Mode

Answer = TypeVar("Answer")

_LIBRARIES = {"openai": "openai", "anthropic": "anthropic", "google": "google.genai"}
_USERS_MISTAKES = {
    401: "the key was refused",
    403: "the key may not use this model",
    404: "there is no such model or address",
    405: "there is no such model or address",
}
_REFUSES_FORM = (400, 415, 422)
_BUSY = (408, 409, 425, 429)
_LETTERS_A_TOKEN = 3  # where a server counts no tokens; of Chinese it is fewer, of English more

_REMINDER = (
    "\n\nAn answer to this was refused: it was not one JSON object as asked for, or it held what was not given. "
    "Keep to the form and to what the user message holds."
)


class NoAnswerError(LpSlamError):
    """The model did not answer, or not with what was asked for."""


class BusyError(NoAnswerError):
    """The model did not answer now; later it may."""


class _FormRefused(Exception):
    """The server takes no schema, or no tools."""


@dataclass(frozen=True, slots=True)
class Question(Generic[Answer]):
    """One question.

    Attributes:
        system: the task and its examples.
        given: what the question is about; it is sent JSON-encoded as the user message.
        schema: of the JSON object that is the answer.
        read: makes the answer of that object; a ValueError, KeyError or TypeError says that it is not allowed.
    """

    system: str
    given: Mapping[str, Any]
    schema: Mapping[str, Any]
    read: Callable[[Mapping[str, Any]], Answer]


class Exchange:
    """Puts questions to one endpoint; may be called from several threads.

    Attributes:
        endpoint: who is asked.
        usage: what it has cost so far.
    """

    def __init__(self, endpoint: Endpoint, config: LanguageConfig, cache: AnswerCache) -> None:
        if find_spec("pydantic_ai") is None or not _is_installed(_LIBRARIES[endpoint.protocol]):
            raise MissingExtraError(f"language model {endpoint.label}", EXTRAS[endpoint.protocol])
        self.endpoint = endpoint
        self.usage = Usage()
        self._config = config
        self._cache = cache
        self._mode: Mode | None = None
        self._mistake: UserError | None = None
        self._was_silent = False
        self._rests_until = 0.0

    def ask(self, questions: Sequence[Question[Answer]]) -> list[Answer | NoAnswerError]:
        """Answer the questions, each for itself; some are put at the same time.

        Raises:
            UserError: the key, the model or the address is wrong.
        """
        answers: dict[int, Answer | NoAnswerError] = {}
        keys = [self._key(question) for question in questions]
        for at, question in enumerate(questions):
            kept = self._cache.get(keys[at])
            try:
                if kept is not None:
                    answers[at] = question.read(kept)
                    self.usage.add_saved()
            except (ValueError, KeyError, TypeError, AttributeError):
                continue
        wanting = [at for at in range(len(questions)) if at not in answers]
        if wanting:
            # Whoever is refused once is refused always: the key does not change within a process.
            if self._mistake is not None:
                raise self._mistake
            fresh = _run(lambda: self._ask_all([questions[at] for at in wanting], [keys[at] for at in wanting]))
            answers.update(zip(wanting, fresh, strict=True))
        return [answers[at] for at in range(len(questions))]

    def _key(self, question: Question[Any]) -> str:
        model = f"{self.endpoint.protocol} {self.endpoint.base_url} {self.endpoint.model}"
        return self._cache.key(model, question.system, question.given, question.schema)

    async def _ask_all(
        self, questions: Sequence[Question[Answer]], keys: Sequence[str]
    ) -> list[Answer | NoAnswerError]:
        try:
            from lpslam.language.hosted.clients import connect
        except ImportError as error:
            raise MissingExtraError(f"language model {self.endpoint.label}", EXTRAS[self.endpoint.protocol]) from error
        places = asyncio.Semaphore(self._config.at_once)

        async def one(at: int) -> Answer | NoAnswerError:
            async with places:
                return await self._ask_one(model, questions[at], keys[at])

        try:
            async with connect(self.endpoint) as model:
                # The first one finds out what the server takes, and whether it is there at all.
                first = await one(0)
                answers = [first, *await asyncio.gather(*(one(at) for at in range(1, len(questions))))]
                await self._ask_again(answers, one)
        except UserError as error:
            self._mistake = error
            raise
        return answers

    async def _ask_again(
        self, answers: list[Answer | NoAnswerError], one: Callable[[int], Awaitable[Answer | NoAnswerError]]
    ) -> None:
        """Put again what was too much for a server that answers: who answers some is there, and needs a rest."""
        idle = 0
        busy = [at for at, answer in enumerate(answers) if isinstance(answer, BusyError)]
        while busy and len(busy) < len(answers) and idle < self._config.rounds:
            await asyncio.sleep(max(0.0, self._rests_until - time.monotonic()))
            self._rests_until, self._was_silent = 0.0, False
            for at, answer in zip(busy, await asyncio.gather(*map(one, busy)), strict=True):
                answers[at] = answer
            left = [at for at in busy if isinstance(answers[at], BusyError)]
            idle = idle + 1 if len(left) == len(busy) else 0
            busy = left

    async def _ask_one(self, model: "Model", question: Question[Answer], key: str) -> Answer | NoAnswerError:
        """Ask, and a second time where the answer is not allowed."""
        refused = ""
        try:
            for reminder in ("", _REMINDER):
                text = await self._put(model, question, question.system + reminder)
                try:
                    tree = _object_in(text)
                    answer = question.read(tree)
                except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
                    refused = clean_text(f"{error} is missing" if isinstance(error, KeyError) else str(error), 100)
                else:
                    self._cache.keep(key, tree)
                    return answer
        except NoAnswerError as error:
            return error
        return NoAnswerError(f"its answer was refused twice: {refused}")

    async def _put(self, model: "Model", question: Question[Any], system: str) -> str:
        """Put a question in the strictest form that the server takes, and remember which one that is."""
        from lpslam.language.hosted.clients import Mode

        modes = list(Mode)
        for mode in modes[modes.index(self._mode or modes[0]) :]:
            try:
                text = await self._patiently(model, question, system, mode)
            except _FormRefused as refusal:
                failure = str(refusal)
                continue
            self._mode = mode
            return text
        raise NoAnswerError(failure)

    async def _patiently(self, model: "Model", question: Question[Any], system: str, mode: "Mode") -> str:
        """Put a question; a busy or failing server is asked again, a little later each time."""
        from pydantic_ai import exceptions

        from lpslam.language.hosted.clients import put

        user = json.dumps(question.given, ensure_ascii=False)
        failure, pause = "", 0.0
        # One that was silent through all of it is tried once after its rest, until it answers.
        for attempt in range(1 if self._was_silent else self._config.attempts):
            if attempt:
                await asyncio.sleep(max(pause, self._config.backoff_s * 2.0 ** (attempt - 1)))
            if time.monotonic() < self._rests_until:
                raise BusyError("it failed a moment ago and is left alone for a while")
            limit = self.usage.begin_call(self._config.max_calls, self._config.max_tokens)
            if limit is not None:
                raise NoAnswerError(limit)
            try:
                async with asyncio.timeout(self._config.timeout_s):
                    text, tokens = await put(model, system, user, question.schema, mode)
            except TimeoutError:
                failure = f"no answer within {self._config.timeout_s:g} s"
                break
            except exceptions.ModelHTTPError as error:
                failure = self._judge_status(error.status_code, str(error.body))
                pause = _asked_wait(error)
                if pause > self._config.longest_wait_s or "insufficient_quota" in str(error.body):
                    break
            except exceptions.ModelAPIError as error:
                failure = f"{self.endpoint.base_url} cannot be reached ({_reason(error)})"
            except exceptions.UnexpectedModelBehavior as error:
                raise NoAnswerError("the server's answer is no chat completion; is the address complete?") from error
            except exceptions.UserError as error:
                # pydantic-ai knows of some models what they do not take.
                raise _FormRefused(clean_text(str(error), 100)) from error
            except Exception as error:
                # Client libraries stumble over odd answers in many ways; none of them is worth a map.
                raise NoAnswerError(f"the server's answer cannot be read ({type(error).__name__})") from error
            else:
                self._was_silent = False
                self.usage.add_tokens(tokens or (len(system) + len(user) + len(text)) // _LETTERS_A_TOKEN)
                return text
        self._was_silent = True
        self._rests_until = time.monotonic() + self._config.rest_s
        raise BusyError(failure)

    def _judge_status(self, status: int, body: str) -> str:
        """Return what a status says that may pass; raise for one that stays."""
        told = body.casefold()
        about_key = status == 400 and ("api key" in told or "api_key" in told)
        if status in _USERS_MISTAKES or about_key:
            reason = _USERS_MISTAKES.get(status, _USERS_MISTAKES[401])
            raise UserError(
                f"language model {self.endpoint.label}: {reason} ({status} from {self.endpoint.base_url}); "
                "check both, or leave --llm out for the embedded model"
            )
        if status in _REFUSES_FORM:
            raise _FormRefused(f"the server refused the question ({status})")
        if status < 500 and status not in _BUSY:
            raise NoAnswerError(f"the server answered {status}")
        return f"the server answered {status}"


def _run(make: Callable[[], Any]) -> Any:
    """Run a coroutine to its end, also where the caller has an event loop of its own (a notebook)."""
    try:
        asyncio.get_running_loop()
    except RuntimeError:
        return asyncio.run(make())
    with ThreadPoolExecutor(1, "language") as pool:
        return pool.submit(lambda: asyncio.run(make())).result()


def _object_in(text: str) -> Mapping[str, Any]:
    """Read the JSON object in an answer; models without a schema like to wrap it in words or a code fence."""
    start, end = text.find("{"), text.rfind("}")
    if start < 0 or end < start:
        raise ValueError("no JSON object in it")
    tree = json.loads(text[start : end + 1])
    if not isinstance(tree, dict):
        raise ValueError("no JSON object in it")
    return tree


def _asked_wait(error: Exception) -> float:
    """Seconds that a busy server asks to be left alone; 0 where it says nothing of it."""
    headers = getattr(error, "headers", None) or getattr(getattr(error.__cause__, "response", None), "headers", {})
    try:
        wait = float(headers.get("retry-after") or 0.0)
    except (ValueError, TypeError, AttributeError):
        return 0.0
    return wait if wait >= 0.0 else 0.0


def _reason(error: BaseException) -> str:
    """The innermost error's own words, which say more than “Connection error.”."""
    while error.__cause__ is not None:
        error = error.__cause__
    return clean_text(str(error), 100) or type(error).__name__


def _is_installed(library: str) -> bool:
    try:
        return find_spec(library) is not None
    except ModuleNotFoundError:
        return False
