"""The name of a class of misread strings (text clustering, III-E), chosen by a language model and never invented."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from lpslam.config import TextConfig
from lpslam.language.model import LanguageModel, NamesTogether, Naming, Reading
from lpslam.language.sanitise import clean_text
from lpslam.text.remembering.memory import TextClass
from lpslam.text.remembering.similarity import comparison_key, similarity

# A name less similar than this to everything that was read is the model's invention.
_NEAREST_READING = 0.5

# A class is named anew once its evidence has grown by this factor: at five readings, and once it is settled.
_GROWTH = 1.5


class BesideNaming(Protocol):
    """A slow model that names classes while mapping goes on; neither call waits for it."""

    def ask(self, key: int, readings: Sequence[Reading]) -> None:
        """Ask for the name of class `key`."""
        ...

    def answers(self) -> list[tuple[int, Naming]]:
        """Fetch the (class, name) that came since the last call."""
        ...


def needs_name(text_class: TextClass) -> bool:
    """Whether a class has no name yet, or has half as many readings again as its name was chosen from."""
    return text_class.naming is None or text_class.count >= _GROWTH * text_class.named_at_count


def name_class(text_class: TextClass, language: "LanguageModel | _Said | None", config: TextConfig) -> bool:
    """Name a class by the language model, or by its surest spelling where there is none or it fails.

    Returns:
        Whether a model that was asked answered usably.
    """
    readings = text_class.readings(config.memory)
    naming, failed = None, False
    if language is not None:
        # Any model behind the protocol may fail in any way; mapping goes on.
        try:
            naming = _checked(language.name(readings), text_class, config.spotting.max_length)
        except Exception:
            naming = None
        failed = naming is None
    text_class.naming = naming or _surest(text_class, readings[0])
    text_class.named_at_count = text_class.count
    return not failed


def name_classes(classes: Sequence[TextClass], language: LanguageModel, config: TextConfig) -> int:
    """Name many classes, in few requests where the model can.

    Returns:
        For how many a model that was asked did not answer usably.
    """
    if not isinstance(language, NamesTogether):
        return sum(not name_class(each, language, config) for each in classes)
    try:
        namings = language.name_all([each.readings(config.memory) for each in classes])
    except Exception:
        # Any model behind the protocol may fail in any way; the map gets its names all the same.
        namings = []
    if len(namings) != len(classes):
        return sum(not name_class(each, None, config) for each in classes) + len(classes)
    return sum(
        not name_class(each, _Said(language.model, name), config) for each, name in zip(classes, namings, strict=True)
    )


@dataclass(frozen=True, slots=True)
class _Said:
    """A model that has given its answer already."""

    model: str
    naming: Naming

    def name(self, readings: Sequence[Reading]) -> Naming:
        return self.naming


def rename_class(text_class: TextClass, naming: Naming, max_length: int) -> bool:
    """Give a class the name that came later from a slow model; one that was not read stays without effect.

    Returns:
        Whether the name was usable.
    """
    checked = _checked(naming, text_class, max_length)
    text_class.naming = checked or text_class.naming
    return checked is not None


def _checked(naming: Naming, text_class: TextClass, max_length: int) -> Naming | None:
    name = clean_text(naming.name, max_length)
    key = comparison_key(name)
    nearest = max(similarity(key, comparison_key(text)) for text in text_class.variants)
    if not key or nearest < _NEAREST_READING:
        return None
    return Naming(name, naming.confidence, naming.evidence, naming.model)


def _surest(text_class: TextClass, best: Reading) -> Naming:
    share = best.count / text_class.count
    return Naming(
        best.text,
        share * (best.confidence if best.right is None else best.right),
        f"read {best.count} of {text_class.count} times",
        "majority",
    )
