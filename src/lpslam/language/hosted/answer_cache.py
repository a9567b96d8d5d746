"""Answers of hosted models kept on disk, so that the same question to the same model is paid for once."""

import hashlib
import json
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from lpslam.language.kept import write_private


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
