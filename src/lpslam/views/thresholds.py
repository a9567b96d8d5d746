"""Every threshold as YAML, below the comment that states its unit and its reason where it is defined."""

import ast
import inspect
import textwrap
import tokenize
from io import StringIO
from typing import Any

import yaml

from lpslam.config.section import Section

_WIDTH = 10_000
"""Characters: a value stays on one line."""


def commented_yaml(section: Section, indent: int = 0) -> str:
    """A section and all below it as YAML; without comments where the package has no source files.

    Args:
        section: of the configuration.
        indent: spaces before every line.
    """
    comments = _comments(type(section))
    space = " " * indent
    lines: list[str] = []
    for name, value in section:
        lines += [f"{space}{comment}" for comment in comments.get(name, [])]
        if isinstance(value, Section):
            lines += [f"{space}{name}:", commented_yaml(value, indent + 2)]
        else:
            lines.append(f"{space}{name}: {_plain(section.model_dump(mode='json')[name])}")
    return "\n".join(lines)


def _plain(value: Any) -> str:
    return (
        yaml.safe_dump(value, default_flow_style=True, allow_unicode=True, width=_WIDTH).removesuffix("...\n").strip()
    )


def _comments(kind: type[Section]) -> dict[str, list[str]]:
    """The comments above and beside each field of a section, and of a section in it the first line that it has."""
    try:
        text = textwrap.dedent(inspect.getsource(kind))
    except (OSError, TypeError):
        return {}
    above: dict[int, str] = {}
    beside: dict[int, str] = {}
    for token in tokenize.generate_tokens(StringIO(text).readline):
        if token.type == tokenize.COMMENT:
            (beside if token.line[: token.start[1]].strip() else above)[token.start[0]] = token.string
    found: dict[str, list[str]] = {}
    body = next(node for node in ast.parse(text).body if isinstance(node, ast.ClassDef)).body
    for field in body:
        if isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name):
            first, last = field.lineno, field.end_lineno or field.lineno
            while first - 1 in above:
                first -= 1
            comments = {line: text for line, text in (above | beside).items() if first <= line <= last}
            found[field.target.id] = [comments[line] for line in sorted(comments)]
    return found
