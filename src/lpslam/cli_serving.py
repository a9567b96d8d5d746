"""Commands that serve maps to others: over HTTP, and to agents; and their tokens."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import typer

from lpslam.cli_checks import config_of
from lpslam.cli_options import Json, Llm
from lpslam.errors import MissingExtraError, UserError
from lpslam.views.browser import open_browser
from lpslam.views.printed import load_matplotlib, print_json, say

Maps = Annotated[
    list[Path] | None, typer.Argument(metavar="MAP...", help="Maps made by 'lpslam run'.", show_default=False)
]
ConfigFile = Annotated[
    Path | None, typer.Option("--config", metavar="FILE", help="YAML overrides of limits; see 'lpslam config'.")
]


def serve(
    maps: Maps = None,
    host: Annotated[str, typer.Option(help="Where to listen; elsewhere than here only with --tokens.")] = "127.0.0.1",
    port: Annotated[int, typer.Option(min=0, max=65535, help="0 for any that is free.")] = 8765,
    tokens: Annotated[
        Path | None, typer.Option("--tokens", metavar="FILE", help="Who may do what; see 'lpslam token'.")
    ] = None,
    uploads: Annotated[
        Path | None, typer.Option("--uploads", metavar="FOLDER", help="Take recordings, and keep their maps there.")
    ] = None,
    allow_host: Annotated[
        list[str] | None, typer.Option("--allow-host", metavar="NAME", help="Another name of this server.")
    ] = None,
    certificate: Annotated[Path | None, typer.Option("--certificate", metavar="FILE", help="For TLS, with --key.")] = (
        None
    ),
    key: Annotated[Path | None, typer.Option("--key", metavar="FILE", help="Of the certificate.")] = None,
    workers: Annotated[
        int | None, typer.Option("--workers", min=0, max=64, help="Processes that answer; 2 without, 0 for threads.")
    ] = None,
    llm: Llm = None,
    config: ConfigFile = None,
) -> None:
    """Serve maps over HTTP: landmarks, questions, events; its schema is at /openapi.json.

    Listens on this machine alone unless --host and --tokens are given. A map that is replaced is served anew.
    """
    _serve(
        Served(maps or [], host, port, tokens, uploads, allow_host or [], certificate, key, workers, llm, config),
        lambda url: None,
    )


@dataclass(frozen=True, slots=True)
class Served:
    """What `serve` is given; its options say what each is."""

    maps: list[Path]
    host: str = "127.0.0.1"
    port: int = 8765
    tokens: Path | None = None
    uploads: Path | None = None
    names: Sequence[str] = ()
    certificate: Path | None = None
    key: Path | None = None
    workers: int | None = None
    llm: str | None = None
    config: Path | None = None


def _serve(given: Served, on_ready: Callable[[str], None], *, page_first: bool = False) -> None:
    """Serve until interrupted; `on_ready` gets the address once requests are answered there.

    With `page_first` the page is there before whoever answers is loaded.
    """
    _need("starlette", "uvicorn", "fastapi", what="lpslam serve", extra="serve")
    from lpslam.serving.http.server import Address, bound, run, url_of
    from lpslam.serving.map_files import refuse_no_maps
    from lpslam.serving.tokens import Tokens

    settings = config_of(given.config)
    address = Address(given.host, given.port, given.certificate, given.key)
    known = Tokens(given.tokens) if given.tokens is not None else None
    if known is None and not address.is_loopback:
        raise UserError(
            f"--host {given.host} can be reached by others, who would need no token: give --tokens FILE, or listen "
            "here alone"
        )
    if (given.certificate is None) != (given.key is None):
        raise UserError("--certificate and --key belong together: give both or neither")
    if not given.maps and given.uploads is None:
        raise UserError("what is to be served? give maps, or --uploads FOLDER for recordings")
    refuse_no_maps(given.maps)
    # A hosted model may be refused, which is said before anything is served.
    language = None if page_first and given.llm is None else _language(given, settings)
    with bound(address) as listening:
        if page_first:
            from lpslam.serving.page_first import page_first as opening

            app: Any = opening(
                given.maps[0],
                settings,
                address.host,
                given.names,
                lambda opened: _whole(given, settings, language or _language(given, settings), known, opened),
            )
        else:
            app = _whole(given, settings, language, known)
        if known is not None and not address.is_loopback and given.certificate is None:
            say("tokens go over the network in the clear: give --certificate and --key, or stand behind a proxy")
        url = url_of(listening, address)

        def ready() -> None:
            say(f"serving at {url}; Ctrl-C ends it")
            on_ready(url)

        run(app, listening, address, settings.serving, ready)


def _language(given: Served, settings: Any) -> Any:
    from lpslam.language.registry import language_model

    return language_model(given.llm, settings.language)


def _whole(given: Served, settings: Any, language: Any, known: Any, opened: Any = None) -> Any:
    """The application with everything that it answers."""
    load_matplotlib()
    from lpslam.serving.assembling import assemble

    return assemble(
        given.maps,
        settings,
        language,
        given.host,
        known,
        given.uploads,
        given.names,
        given.workers,
        opened,
    )


def view(
    map_file: Annotated[Path, typer.Argument(metavar="MAP", help="A map made by 'lpslam run'.", show_default=False)],
    port: Annotated[int, typer.Option(min=0, max=65535, help="0 for any that is free.")] = 8765,
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="Open the page.")] = True,
    llm: Llm = None,
    config: ConfigFile = None,
) -> None:
    """Show a map on a page, on this machine alone: look, search, ask and be led. Ctrl-C ends it."""
    _serve(
        Served([map_file], port=port, llm=llm, config=config),
        open_browser if browser else lambda url: None,
        page_first=True,
    )


@contextmanager
def watched(title: str, total: int, port: int, settings: Any, llm: str | None) -> Iterator[Any]:
    """A page of a map that is being made: hand its `on_step` to the run, and its `end` the map.

    Raises:
        UserError: the port is taken, or the page cannot be served.
    """
    _need("starlette", "uvicorn", "fastapi", what="lpslam run --view", extra="serve")
    from lpslam.serving.watching.feed import Feed
    from lpslam.serving.watching.wire import Begin

    lost = "the page is lost; the run goes on without it"
    with Feed(Begin(title, port, settings, llm, total), lambda: say(lost)) as feed:
        say(f"the map can be watched at {feed.url}")
        open_browser(feed.url)
        yield feed


@contextmanager
def unwatched() -> Iterator[Any]:
    """The same where nobody wants a page."""

    class Nobody:
        def on_step(self, frame: Any, step: Any, session: Any) -> None:
            pass

        def end(self, world: Any, map_file: str) -> None:
            pass

    yield Nobody()


def mcp(
    maps: Annotated[list[Path], typer.Argument(metavar="MAP...", help="Maps made by 'lpslam run'.")],
    llm: Llm = None,
    config: ConfigFile = None,
) -> None:
    """Give maps to an agent as tools (Model Context Protocol), over standard input and output. Nothing is written."""
    _need("mcp", what="lpslam mcp", extra="mcp")
    from lpslam.serving.map_files import refuse_no_maps

    refuse_no_maps(maps)
    load_matplotlib()
    from lpslam.language.registry import language_model
    from lpslam.serving.agents import agent_server
    from lpslam.serving.atlas import Atlas

    settings = config_of(config)
    language = language_model(llm, settings.language)
    agent_server(Atlas(maps, settings.navigation), language, settings).run("stdio")


def token(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="Where tokens are kept, as digests.")],
    name: Annotated[str, typer.Option("--name", metavar="NAME", help="Of whoever gets it.")],
    scope: Annotated[
        list[str] | None,
        typer.Option("--scope", metavar="SCOPE", help="read, ask, map, write; without: read, ask."),
    ] = None,
    days: Annotated[float | None, typer.Option("--days", min=0, max=36500, help="Until it expires.")] = 90.0,
    as_json: Json = False,
) -> None:
    """Make a token for 'lpslam serve --tokens FILE'. It is shown once; to withdraw it, remove its entry."""
    from lpslam.serving.tokens import add_token

    made = add_token(file, name, scope or ["read", "ask"], days)
    if as_json:
        print_json({"name": name, "token": made, "file": str(file)})
    else:
        print(made)
        say(f"kept in {file} as a digest; the token itself is shown this once")


def _need(*modules: str, what: str, extra: str) -> None:
    """Raise where an optional part is not installed."""
    from importlib.util import find_spec

    if any(find_spec(module) is None for module in modules):
        raise MissingExtraError(what, extra)


COMMANDS: tuple[Any, ...] = (serve, view, mcp, token)
