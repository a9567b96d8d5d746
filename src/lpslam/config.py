"""Every threshold that the paper or this project names, in one typed tree.

Defaults live here; a YAML file may override any of them (`Config.from_yaml`). Units are in the names or the comment.
"""

from pathlib import Path
from typing import Any

from pydantic import BaseModel, ConfigDict, ValidationError

from lpslam.errors import UserError


class _Section(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class Config(_Section):
    """The whole tree."""

    @classmethod
    def from_yaml(cls, path: Path) -> "Config":
        """Read overrides from a YAML file; unknown or ill-typed keys are a `UserError`."""
        import yaml

        try:
            tree: Any = yaml.safe_load(path.read_text(encoding="utf-8")) or {}
            return cls.model_validate(tree)
        except OSError as error:
            raise UserError(f"configuration {path} cannot be read ({error.strerror})") from error
        except yaml.YAMLError as error:
            raise UserError(f"configuration {path} is not YAML: {' '.join(str(error).split())}") from error
        except ValidationError as error:
            first = error.errors()[0]
            where = ".".join(str(part) for part in first["loc"])
            raise UserError(f"configuration {path}: {where}: {first['msg']}") from error
