"""What all sections of the configuration have in common: defaults at hand, and checks of what somebody gives.

Defaults are checked by a test, and need no check in every process. pydantic checks what is given, and is loaded then:
to load it, and to make its schemas of five hundred thresholds, takes as long as many an answer.
"""

import json
from collections.abc import Iterator, Mapping
from dataclasses import FrozenInstanceError, dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self, dataclass_transform, get_type_hints

from annotated_types import Ge, Gt, Le, Lt, MinLen

if TYPE_CHECKING:
    from pydantic import GetCoreSchemaHandler, TypeAdapter
    from pydantic_core import CoreSchema

PositiveFloat = Annotated[float, Gt(0.0)]


_LIMITS = {"gt": Gt, "ge": Ge, "lt": Lt, "le": Le, "min_length": MinLen}


@dataclass(frozen=True, slots=True)
class _Threshold:
    """A default, and between what its like must lie."""

    default: Any
    limits: tuple[Any, ...]


def Field(*, default: Any, **limits: float) -> Any:
    """A threshold with its limits: `gt` more than, `ge` at least, `lt` less than, `le` at most, `min_length`."""
    return _Threshold(default, tuple(_LIMITS[name](limit) for name, limit in limits.items()))


@dataclass_transform(kw_only_default=True, frozen_default=True, field_specifiers=(Field,))
class Section:
    """Thresholds that belong together: finite, not negative, none that is unknown, and not to be changed.

    Its methods are named as those of pydantic's models, and raise its `ValidationError`.
    """

    model_fields: ClassVar[Mapping[str, Any]] = MappingProxyType({})
    """The default of each threshold."""
    _limits: ClassVar[Mapping[str, tuple[Any, ...]]] = MappingProxyType({})

    def __init_subclass__(cls) -> None:
        said = {name: cls.__dict__[name] for name in cls.__annotations__}
        cls._limits = {name: each.limits for name, each in said.items() if isinstance(each, _Threshold)}
        defaults = {name: each.default if isinstance(each, _Threshold) else each for name, each in said.items()}
        cls.model_fields = MappingProxyType(defaults)
        for name, default in defaults.items():
            setattr(cls, name, default)

    def __init__(self, **given: Any) -> None:
        self.__dict__.update(_schema_of(type(self)).validate_python(given).__dict__ if given else self.model_fields)

    def __setattr__(self, name: str, value: Any) -> None:
        raise FrozenInstanceError(f"{type(self).__name__}.{name} cannot be changed; make another with model_copy")

    def __delattr__(self, name: str) -> None:
        raise FrozenInstanceError(f"{type(self).__name__}.{name} cannot be taken away")

    def __iter__(self) -> Iterator[tuple[str, Any]]:
        return iter(self.__dict__.items())

    def __eq__(self, other: object) -> bool:
        return type(other) is type(self) and other.__dict__ == self.__dict__

    def __hash__(self) -> int:
        return hash((type(self), *self.__dict__.values()))

    def __repr__(self) -> str:
        return f"{type(self).__name__}({', '.join(f'{name}={value!r}' for name, value in self)})"

    @classmethod
    def model_validate(cls, given: Any) -> Self:
        """A section by what is given of it, as a mapping; the rest is as by default.

        Raises:
            ValidationError: there is no such threshold, or it is of another type or out of its limits.
        """
        checked: Self = _schema_of(cls).validate_python(given)
        return checked

    @classmethod
    def model_validate_json(cls, given: str | bytes) -> Self:
        """The same of JSON."""
        checked: Self = _schema_of(cls).validate_json(given)
        return checked

    def model_copy(self, *, update: Mapping[str, Any] | None = None) -> Self:
        """The same but for what is given, which is not checked."""
        return self._of({**self.__dict__, **(update or {})})

    def model_dump(self, *, mode: str = "python") -> dict[str, Any]:
        """All of it as plain values; by mode "json" as JSON has them."""
        return {
            name: value.model_dump(mode=mode)
            if isinstance(value, Section)
            else list(value)
            if mode == "json" and isinstance(value, tuple)
            else value
            for name, value in self
        }

    def model_dump_json(self) -> str:
        """All of it as JSON."""
        return json.dumps(self.model_dump(mode="json"))

    @classmethod
    def _of(cls, values: Mapping[str, Any]) -> Self:
        made = cls.__new__(cls)
        made.__dict__.update({**cls.model_fields, **values})
        return made

    @classmethod
    def __get_pydantic_core_schema__(cls, source: Any, handler: "GetCoreSchemaHandler") -> "CoreSchema":
        from pydantic import AfterValidator, ConfigDict, with_config
        from pydantic_core.core_schema import no_info_wrap_validator_function
        from typing_extensions import TypedDict

        thresholds = {
            name: Annotated[kind, *cls._limits.get(name, ()), AfterValidator(_refuse_negative)]
            for name, kind in get_type_hints(cls, include_extras=True).items()
            if name in cls.model_fields
        }
        form: Any = with_config(ConfigDict(extra="forbid", allow_inf_nan=False))(
            TypedDict(cls.__name__, thresholds, total=False)  # type: ignore[operator]
        )

        def checked(given: Any, check: Any) -> Any:
            return given if isinstance(given, cls) else cls._of(check(given))

        return no_info_wrap_validator_function(checked, handler.generate_schema(form))


_SCHEMAS: "dict[type[Section], TypeAdapter[Any]]" = {}


def _schema_of(section: type[Section]) -> "TypeAdapter[Any]":
    if section not in _SCHEMAS:
        from pydantic import TypeAdapter

        _SCHEMAS[section] = TypeAdapter(section)
    return _SCHEMAS[section]


def _refuse_negative(value: Any) -> Any:
    """None of the thresholds means anything below nought."""
    if isinstance(value, int | float) and value < 0:
        raise ValueError("must not be negative")
    return value
