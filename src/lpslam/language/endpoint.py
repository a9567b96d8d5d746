"""One chat endpoint that speaks the OpenAI protocol: where it is, its key, and one exchange with it."""

import os
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from lpslam.config import LanguageConfig
from lpslam.errors import LpSlamError, MissingExtraError, UserError

if TYPE_CHECKING:
    import httpx

_LONGEST_WAIT = 20.0  # seconds; a server that asks for more is not waited for
_USERS_MISTAKES = {
    401: "the key was refused",
    403: "the key may not use this model",
    404: "there is no such model or address",
}


class NoAnswerError(LpSlamError):
    """The endpoint did not answer, or not with what was asked for."""


@dataclass(frozen=True, slots=True)
class Endpoint:
    """Address, model and key of a chat endpoint; `label` is how the model is reported."""

    base_url: str
    model: str
    label: str
    key: str | None = field(default=None, repr=False)

    @classmethod
    def from_spec(cls, spec: str) -> "Endpoint | None":
        """Read "openai:MODEL", "ollama:MODEL" or "URL#MODEL"; None where `spec` is none of them.

        Keys come from the environment alone: OPENAI_API_KEY, or LPSLAM_LLM_API_KEY (optional) for a URL.
        """
        provider, _, model = spec.partition(":")
        if provider == "openai" and model:
            key = os.environ.get("OPENAI_API_KEY")
            if not key:
                raise UserError(f"language model {spec} needs a key: set the environment variable OPENAI_API_KEY")
            return cls(os.environ.get("OPENAI_BASE_URL") or "https://api.openai.com/v1", model, spec, key)
        if provider == "ollama" and model:
            host = os.environ.get("OLLAMA_HOST") or "localhost:11434"
            address = host if "://" in host else f"http://{host}"
            return cls(f"{address.rstrip('/')}/v1", model, spec)
        url, _, model = spec.partition("#")
        if url.startswith(("http://", "https://")) and model:
            return cls(url.rstrip("/"), model, spec, os.environ.get("LPSLAM_LLM_API_KEY") or None)
        return None


class Chat:
    """Exchanges with one endpoint: a JSON object as text comes back, or a `NoAnswerError`."""

    def __init__(self, endpoint: Endpoint, config: LanguageConfig) -> None:
        try:
            import httpx
        except ImportError as error:
            raise MissingExtraError(f"language model {endpoint.label}", "llm") from error
        self._httpx = httpx
        self.endpoint = endpoint
        self._config = config
        self._takes_schema = True
        self._is_silent = False

    def complete(self, system: str, user: str, schema: Mapping[str, Any]) -> str:
        """Send one system and one user message; ask for `schema` as long as the server takes that."""
        body: dict[str, Any] = {
            "model": self.endpoint.model,
            "messages": [{"role": "system", "content": system}, {"role": "user", "content": user}],
        }
        if self._takes_schema:
            structured = {"type": "json_schema", "json_schema": {"name": "answer", "schema": dict(schema)}}
            response = self._post({**body, "response_format": structured})
            if response.status_code in (400, 422):
                # Not every server knows `response_format`; the prompt asks for JSON in words as well.
                self._takes_schema = False
        if not self._takes_schema:
            response = self._post(body)
        if response.status_code in _USERS_MISTAKES:
            reason = _USERS_MISTAKES[response.status_code]
            raise UserError(f"language model {self.endpoint.label}: {reason} ({response.status_code}); check both")
        if response.status_code != 200:
            raise NoAnswerError(f"the server answered {response.status_code}")
        try:
            return str(response.json()["choices"][0]["message"]["content"])
        except (ValueError, KeyError, IndexError, TypeError) as error:
            raise NoAnswerError("the server's answer is no chat completion") from error

    def _post(self, body: Mapping[str, Any]) -> "httpx.Response":
        """Post with patience: a busy or failing server is asked again, a little later each time.

        One that stayed silent through all of it is asked once a request from then on, until it answers: a whole map of
        names must not wait for a server that is down.
        """
        headers = {"Authorization": f"Bearer {self.endpoint.key}"} if self.endpoint.key else {}
        failure = "no attempt was made"
        for attempt in range(1 if self._is_silent else self._config.attempts):
            if attempt:
                time.sleep(self._config.backoff_s * 2.0 ** (attempt - 1))
            try:
                response = self._httpx.post(
                    f"{self.endpoint.base_url}/chat/completions",
                    json=dict(body),
                    headers=headers,
                    timeout=self._config.timeout_s,
                )
            except self._httpx.InvalidURL as error:
                raise UserError(f"language model {self.endpoint.label}: the address is no URL") from error
            except self._httpx.HTTPError as error:
                failure = f"{self.endpoint.base_url} cannot be reached ({type(error).__name__})"
                continue
            if response.status_code != 429 and response.status_code < 500:
                self._is_silent = False
                return response
            failure = f"the server answered {response.status_code}"
            time.sleep(_asked_wait(response.headers.get("Retry-After")))
        self._is_silent = True
        raise NoAnswerError(failure)


def _asked_wait(header: str | None) -> float:
    """Seconds that a busy server asks to be left alone; 0 where it says nothing that can be met."""
    try:
        wait = float(header or 0.0)
    except ValueError:
        return 0.0
    return wait if 0.0 <= wait <= _LONGEST_WAIT else 0.0
