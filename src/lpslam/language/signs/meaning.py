"""What a sign means, and what follows from names and words that are found in it."""

from collections.abc import Sequence
from dataclasses import dataclass

from lpslam.language.signs.wording import WARNING, reads_like_a_name
from lpslam.language.tables.painted import Known


@dataclass(frozen=True, slots=True)
class SignMeaning:
    """Kinds of place (or of sign) by weight in 0..1, who they belong to, and why.

    `identity` is the known brand or maker; `name_like` says that an unknown text reads like a proper name.
    """

    kinds: tuple[tuple[str, float], ...]
    evidence: str
    identity: str | None = None
    name_like: bool = False

    @property
    def is_place(self) -> bool:
        """Whether the sign names somewhere to go rather than warns, advertises or says nothing."""
        return any(not kind.startswith("sign") for kind, _ in self.kinds)

    @property
    def warns(self) -> bool:
        """Whether the sign warns or forbids."""
        return any(kind == WARNING for kind, _ in self.kinds)


def of_known(known: Known, sure: float, evidence: str, words: dict[str, float] | None = None) -> SignMeaning:
    """What a known name is, and what is told by other `words` beside it."""
    kinds = {kind: sure * weight for kind, weight in known.kinds}
    for kind, weight in (words or {}).items():
        if not kind.startswith("sign"):
            kinds.setdefault(kind, 0.8 * weight)
    return SignMeaning(tuple(kinds.items()), evidence, known.identity if known.source == "brand" else None)


def as_unknown(text: str, units: Sequence[str]) -> SignMeaning:
    """A text that no table knows: perhaps a proper name."""
    name_like = reads_like_a_name(text, units)
    told = "is not known but reads like a name" if name_like else "is not known"
    return SignMeaning((), f"“{text}” {told}", name_like=name_like)


def joined(parts: Sequence[SignMeaning]) -> SignMeaning:
    """Join what the parts of a sign say; a warning in one of them makes the whole a warning."""
    for part in parts:
        if part.warns:
            return part
    telling = [part for part in parts if part.kinds] or list(parts)
    kinds: dict[str, float] = {}
    for part in telling:
        for kind, weight in part.kinds:
            kinds[kind] = max(weight, kinds.get(kind, 0.0))
    if any(not kind.startswith("sign") for kind in kinds):
        kinds = {kind: weight for kind, weight in kinds.items() if not kind.startswith("sign")}
    return SignMeaning(
        tuple(kinds.items()),
        "; ".join(part.evidence for part in telling),
        next((part.identity for part in telling if part.identity), None),
        any(part.name_like for part in parts),
    )
