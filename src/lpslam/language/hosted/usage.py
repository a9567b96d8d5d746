"""What asking a hosted model has cost, the limit of it, and answers kept on disk, so that each is paid for once."""

import hashlib
import json
import threading
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from lpslam.language.kept import write_private
from lpslam.language.model import LanguageModel


class Usage:
    """Calls made and tokens used by one model in this process; safe to share between threads.

    Attributes:
        calls: requests sent, those that failed included.
        tokens: in and out, as the server counted them, or estimated from the text where it does not say.
        saved: questions whose answer was on disk already.
    """

    def __init__(self) -> None:
        self.calls = 0
        self.tokens = 0
        self.saved = 0
        self._lock = threading.Lock()

    def begin_call(self, most_calls: int, most_tokens: int) -> str | None:
        """Count a call that is about to be made; the reason why not, where a limit is reached."""
        with self._lock:
            if self.calls >= most_calls:
                return f"the limit of {most_calls:,} calls is reached (language.max_calls)"
            if self.tokens >= most_tokens:
                return f"the limit of {most_tokens:,} tokens is reached (language.max_tokens)"
            self.calls += 1
            return None

    def add_tokens(self, tokens: int) -> None:
        """Count what a call has used."""
        with self._lock:
            self.tokens += tokens

    def add_saved(self) -> None:
        """Count an answer that was taken from disk."""
        with self._lock:
            self.saved += 1

    def __str__(self) -> str:
        """As it is shown: "3 calls, 1,240 tokens"."""
        told = f"{_number(self.calls, 'call')}, {_number(self.tokens, 'token')}"
        return f"{told}, {_number(self.saved, 'answer')} kept from earlier" if self.saved else told


def usage_of(language: LanguageModel) -> Usage | None:
    """What a model has cost; None for a model that costs nothing."""
    usage = getattr(language, "usage", None)
    return usage if isinstance(usage, Usage) else None


def _number(count: int, what: str) -> str:
    return f"{count:,} {what}" if count == 1 else f"{count:,} {what}s"


class AnswerCache:
    """JSON answers in one file each, named by a hash of the model, the prompt and the input.

    Neither a key nor a question stands in the files. A folder that cannot be written and an entry that cannot be read
    do no harm: the question is asked.
    """

    def __init__(self, folder: Path | None) -> None:
        self._folder = folder

    def key(self, model: str, prompt: str, given: Mapping[str, Any], schema: Mapping[str, Any]) -> str:
        """Return the name of an answer: of which model, to which wording of the task, about what."""
        asked = json.dumps([model, prompt, given, schema], ensure_ascii=False, sort_keys=True)
        return hashlib.sha256(asked.encode()).hexdigest()

    def get(self, key: str) -> Mapping[str, Any] | None:
        """Return a kept answer, or None."""
        if self._folder is None:
            return None
        try:
            answer = json.loads(self._path(self._folder, key).read_text(encoding="utf-8"))
        except (OSError, ValueError, RecursionError):
            return None
        return answer if isinstance(answer, dict) else None

    def keep(self, key: str, answer: Mapping[str, Any]) -> None:
        """Write an answer, whole or not at all."""
        if self._folder is None:
            return
        with suppress(ValueError):
            write_private(self._path(self._folder, key), json.dumps(answer, ensure_ascii=False).encode("utf-8"))

    def _path(self, folder: Path, key: str) -> Path:
        return folder / key[:2] / f"{key}.json"
