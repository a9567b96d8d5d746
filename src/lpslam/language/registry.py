"""Which language model a specification means; a new model is one line here."""

from lpslam.errors import UserError
from lpslam.language.model import LanguageModel


def language_model(spec: str | None = None) -> LanguageModel:
    """Return the model for `spec`: None or "offline" is the embedded one; see `docs/language.md` for the others.

    Raises `UserError` for a specification that means nothing.
    """
    if spec is None or spec.strip().lower() in ("", "offline"):
        from lpslam.language.offline import OfflineModel

        return OfflineModel()
    raise UserError(f"language model '{spec}' is not known: use offline, openai:MODEL, ollama:MODEL or URL#MODEL")
