"""What all sections of the configuration have in common."""

from typing import Any

from pydantic import BaseModel, ConfigDict, field_validator


class Section(BaseModel):
    """Thresholds that belong together: finite, not negative, and none that is unknown."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    @field_validator("*")
    @classmethod
    def _refuse_negative(cls, value: Any) -> Any:
        """None of the thresholds means anything below nought."""
        if isinstance(value, int | float) and value < 0:
            raise ValueError("must not be negative")
        return value
