"""JSON values as the dataclasses that they were, every value of the type that its field declares."""

from functools import cache
from typing import Any

from pydantic import TypeAdapter, ValidationError


def restored(kind: Any, value: Any) -> Any:
    """A value of a kind: a dataclass, or a container of some, from what `asdict` and JSON made of it.

    Raises:
        ValueError: a value is missing or has another type; it says where.
    """
    try:
        return _adapter(kind).validate_python(value)
    except ValidationError as error:
        first = error.errors(include_url=False, include_context=False, include_input=False)[0]
        where = ".".join(str(part)[:_SHOWN] for part in first["loc"])
        raise ValueError(f"{where!r}: {first['msg']}") from None


@cache
def _adapter(kind: Any) -> TypeAdapter[Any]:
    return TypeAdapter(kind)


_SHOWN = 40
"""Letters of a key that an error shows: keys are texts read from the world."""
