"""What asking a hosted model has cost so far, and the limit of it."""

import threading

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
