"""Which language model a specification means; a new kind of model is a few lines here and a file of its own."""

from typing import TYPE_CHECKING

from lpslam.errors import UserError
from lpslam.language.model import LanguageModel

if TYPE_CHECKING:
    # What the embedded model does without is half of its start.
    from lpslam.config import LanguageConfig


def language_model(spec: str | None = None, config: "LanguageConfig | None" = None) -> LanguageModel:
    """Return the model for `spec`.

    None or "offline": the embedded model. "openai:MODEL", "anthropic:MODEL", "google:MODEL", "ollama:MODEL" or
    "URL#MODEL" (any OpenAI-compatible address): a hosted or local one, with the embedded model beside it.

    Raises:
        UserError: anything else, a key that is missing, or an optional part that is not installed.
    """
    from lpslam.language.offline import OfflineModel

    wanted = (spec or "offline").strip()
    if wanted.lower() == "offline":
        return OfflineModel()

    from lpslam.language.hosted.endpoint import Endpoint

    endpoint = Endpoint.from_spec(wanted)
    if endpoint is None:
        raise UserError(
            f"language model '{wanted}' is not known: use offline, openai:MODEL, anthropic:MODEL, google:MODEL, "
            "ollama:MODEL or URL#MODEL"
        )

    from lpslam.language.hosted.chat import ChatModel

    return ChatModel(endpoint, OfflineModel(), config)
