"""YAML of a file that somebody else may have written: small, flat enough, and without copies of copies."""

from typing import Any

import yaml

_MOST_LETTERS = 1 << 18
"""More than any calibration or configuration has; reading takes memory and time many times as much."""
_LONGEST_VALUE = 2000
"""Letters; Python refuses to print whole numbers of 4,300 digits and more."""
_DEEPEST = 50
"""Values within values; the time for reading grows with the square of the depth."""
_OPENING = (
    yaml.FlowSequenceStartToken, yaml.FlowMappingStartToken, yaml.BlockSequenceStartToken, yaml.BlockMappingStartToken
)  # fmt: skip
_CLOSING = (yaml.FlowSequenceEndToken, yaml.FlowMappingEndToken, yaml.BlockEndToken)


def yaml_of(text: str, loader: type[yaml.SafeLoader] = yaml.SafeLoader) -> Any:
    """The values of a YAML text.

    Args:
        text: what the file holds.
        loader: what is made of its words.

    Raises:
        ValueError: one line that says what it is instead.
    """
    if len(text) > _MOST_LETTERS:
        raise ValueError(f"it has {len(text):,} letters, more than {_MOST_LETTERS:,}")
    try:
        depth = 0
        # A few aliases of aliases are millions of values.
        for token in yaml.scan(text, loader):
            depth += isinstance(token, _OPENING) - isinstance(token, _CLOSING)
            if depth > _DEEPEST:
                raise ValueError("it is nested too deeply")
            if isinstance(token, yaml.AliasToken):
                raise ValueError("it has aliases (*name); write the values themselves")
            if isinstance(token, yaml.ScalarToken) and len(token.value) > _LONGEST_VALUE:
                raise ValueError(f"it has a value of {len(token.value):,} letters")
        return yaml.load(text, Loader=loader)
    except RecursionError:
        raise ValueError("it is nested too deeply") from None
    except (yaml.YAMLError, ValueError, AttributeError, TypeError, KeyError, OverflowError) as error:
        raise ValueError(" ".join(str(error).split())[:200]) from error
