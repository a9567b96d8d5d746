"""What a specification of a hosted or local model means: which protocol, where, which model, which key."""

import os
from dataclasses import dataclass, field
from typing import Literal
from urllib.parse import urlsplit

from lpslam.errors import UserError

Protocol = Literal["openai", "anthropic", "google"]

EXTRAS: dict[Protocol, str] = {"openai": "llm", "anthropic": "anthropic", "google": "google"}
"""The optional part of the package that speaks each protocol."""

# Where each provider's key is looked for, and what may move the provider to another address.
_KEYS: dict[Protocol, tuple[str, ...]] = {
    "openai": ("OPENAI_API_KEY",),
    "anthropic": ("ANTHROPIC_API_KEY",),
    "google": ("GOOGLE_API_KEY", "GEMINI_API_KEY"),
}
_ADDRESSES: dict[Protocol, tuple[str, str]] = {
    "openai": ("OPENAI_BASE_URL", "https://api.openai.com/v1"),
    "anthropic": ("ANTHROPIC_BASE_URL", "https://api.anthropic.com"),
    "google": ("GOOGLE_GEMINI_BASE_URL", "https://generativelanguage.googleapis.com"),
}


@dataclass(frozen=True, slots=True)
class Endpoint:
    """Protocol, address, model and key of a chat endpoint; `label` is how the model is reported."""

    protocol: Protocol
    base_url: str
    model: str
    label: str
    key: str | None = field(default=None, repr=False)

    @classmethod
    def from_spec(cls, spec: str) -> "Endpoint | None":
        """Read "openai:MODEL", "anthropic:MODEL", "google:MODEL", "ollama:MODEL" or "URL#MODEL"; None for others.

        Keys come from the environment alone, and a provider's key goes to that provider alone; a URL has
        LPSLAM_LLM_API_KEY, where it wants one.

        Raises:
            UserError: the key is missing, or the address is none.
        """
        provider, _, model = spec.partition(":")
        hosted: dict[str, Protocol] = {"openai": "openai", "anthropic": "anthropic", "google": "google"}
        if provider in hosted and model:
            return cls._hosted(hosted[provider], model, spec)
        if provider == "ollama" and model:
            host = os.environ.get("OLLAMA_HOST") or "localhost:11434"
            return cls._compatible(f"{host if '://' in host else f'http://{host}'}".rstrip("/") + "/v1", model, spec)
        url, _, model = spec.partition("#")
        if url.startswith(("http://", "https://")) and model:
            return cls._compatible(url.rstrip("/"), model, spec, os.environ.get("LPSLAM_LLM_API_KEY") or None)
        return None

    @classmethod
    def _hosted(cls, provider: Protocol, model: str, spec: str) -> "Endpoint":
        key = next((os.environ[name] for name in _KEYS[provider] if os.environ.get(name)), None)
        if key is None:
            raise UserError(
                f"language model {spec} needs a key: set the environment variable {_KEYS[provider][0]}, "
                "or leave --llm out for the embedded model"
            )
        variable, usual = _ADDRESSES[provider]
        address = _checked(os.environ.get(variable) or usual, spec)
        return cls(provider, address, model, spec, key)

    @classmethod
    def _compatible(cls, address: str, model: str, spec: str, key: str | None = None) -> "Endpoint":
        return cls("openai", _checked(address, spec), model, spec, key)


def _checked(address: str, spec: str) -> str:
    try:
        parts = urlsplit(address)
        is_address = bool(parts.hostname) and parts.port != 0 and parts.scheme in ("http", "https")
    except ValueError:
        is_address = False
    if not is_address or any(ch.isspace() for ch in address):
        raise UserError(f"language model {spec}: {address} is no address; it should look like http://HOST:PORT/v1")
    return address.rstrip("/")
