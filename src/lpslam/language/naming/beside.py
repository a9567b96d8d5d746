"""Names from a slow model while mapping goes on: a question is handed over, its answer is fetched when it is there."""

import threading
import time
from collections.abc import Sequence
from dataclasses import replace

from lpslam.language.model import LanguageModel, Naming, Reading


class NamingBeside:
    """Asks a language model for names of classes in a thread of its own; neither handing over nor fetching waits.

    Of several questions about one class only the latest is asked, and none twice with the same evidence. Where the
    model raises, another one answers and the answer says so.
    """

    def __init__(self, language: LanguageModel, instead: LanguageModel) -> None:
        self._language = language
        self._instead = instead
        self._waiting: dict[int, tuple[Reading, ...]] = {}
        self._asked: dict[int, tuple[Reading, ...]] = {}
        self._answered: dict[int, Naming] = {}
        self._changed = threading.Condition()
        self._is_working = False

    def ask(self, key: int, readings: Sequence[Reading]) -> None:
        """Ask for the name of class `key`; its later evidence replaces a question that was not yet put."""
        evidence = tuple(readings)
        with self._changed:
            if self._asked.get(key) == evidence:
                return
            self._asked[key] = evidence
            self._waiting[key] = evidence
            if not self._is_working:
                self._is_working = True
                # A daemon, so that a model that does not answer never keeps a process from ending.
                threading.Thread(target=self._work, name="naming", daemon=True).start()

    def answers(self) -> list[tuple[int, Naming]]:
        """Fetch the (class, name) that came since the last call."""
        with self._changed:
            answered, self._answered = self._answered, {}
        return list(answered.items())

    def finish(self, patience_s: float) -> int:
        """Wait until every question is answered, at most so many seconds.

        Returns:
            How many questions stay without an answer; those that were not yet put are dropped.
        """
        end = time.monotonic() + patience_s
        with self._changed:
            self._changed.wait_for(lambda: not self._is_working, max(0.0, end - time.monotonic()))
            unanswered = len(self._waiting) + self._is_working
            self._waiting.clear()
        return unanswered

    def _work(self) -> None:
        while True:
            with self._changed:
                if not self._waiting:
                    self._is_working = False
                    self._changed.notify_all()
                    return
                key = next(iter(self._waiting))
                readings = self._waiting.pop(key)
            answer = self._name(readings)
            with self._changed:
                self._answered[key] = answer

    def _name(self, readings: Sequence[Reading]) -> Naming:
        # Any model behind the protocol may fail in any way; the map gets its names all the same.
        try:
            return self._language.name(readings)
        except Exception as error:
            own = self._instead.name(readings)
            told = " ".join(str(error).split()) or type(error).__name__
            return replace(
                own,
                evidence=f"{own.evidence} [{self._language.model} did not answer: {told}]",
                model=f"{own.model} (instead of {self._language.model})",
            )
