"""Options that several commands have."""

from pathlib import Path
from typing import Annotated

import typer

Llm = Annotated[
    str | None,
    typer.Option(
        "--llm", metavar="MODEL", help="offline (default), openai:, anthropic:, google: or ollama:MODEL, or URL#MODEL."
    ),
]
Json = Annotated[bool, typer.Option("--json", help="Print JSON on standard output.")]
ConfigFile = Annotated[
    Path | None, typer.Option("--config", metavar="FILE", help="YAML overrides of thresholds; see 'lpslam config'.")
]
