"""A server put together from what the command line says."""

import os
from collections.abc import Sequence
from pathlib import Path

from lpslam.config import Config
from lpslam.language.model import LanguageModel
from lpslam.language.offline import OfflineModel
from lpslam.mapfile.language_map import LanguageMap
from lpslam.page.routes import Found, Pages, page_routes
from lpslam.serving.answerers import Answerer, ProcessAnswerer, ThreadAnswerer
from lpslam.serving.atlas import Atlas, NoSuchMapError
from lpslam.serving.http.app import build_app
from lpslam.serving.http.services import Services
from lpslam.serving.http.shield import Door, Shield, allowed_hosts
from lpslam.serving.hub import Hub
from lpslam.serving.jobs.queue import Jobs
from lpslam.serving.page_first import Opened
from lpslam.serving.tokens import Tokens

_WORKERS = 2  # processes that answer, where there are as many cores


def assemble(
    maps: Sequence[Path],
    config: Config,
    language: LanguageModel,
    host: str,
    tokens: Tokens | None,
    uploads: Path | None,
    names: Sequence[str],
    workers: int | None,
    opened: Opened | None = None,
) -> Shield:
    """The application for some maps.

    Args:
        maps: files.
        config: limits and thresholds.
        language: answers questions.
        host: where the server listens.
        tokens: who may do what.
        uploads: folder for uploads; None where none are taken.
        names: other names of the server.
        workers: processes that answer; of a model that is not the embedded one, threads do.
        opened: what is open already of one of the maps.

    Raises:
        UserError: a map cannot be read, two have one name, or uploads cannot be kept.
    """
    limits = config.serving
    atlas = Atlas((), config.navigation)
    for path in [*maps, *(Jobs.kept_maps(uploads) if uploads is not None else ())]:
        atlas.add(path, read=opened.read if opened is not None and path == opened.path else None)
    longest = config.language.question_length
    count = min(_WORKERS, os.cpu_count() or 1) if workers is None else workers
    answerer: Answerer
    if isinstance(language, OfflineModel) and count:
        answerer = ProcessAnswerer(count, longest, limits.waiting_questions, limits.answer_s, limits.answers_kept)
    else:
        answerer = ThreadAnswerer(language, longest, limits.waiting_questions)
    pages = Pages(_finder(atlas), config.page) if opened is None else opened.pages
    pages.find = _finder(atlas)
    services = Services(
        atlas,
        answerer,
        Hub(limits.listeners, limits.waiting_events),
        config,
        uploads,
        language=language,
        answers_later=opened is not None,
    )
    door = Door(allowed_hosts(host, names), tokens, limits, streams=frozenset({"/jobs"}))
    # A browser cannot give a token with a page's first request.
    return build_app(services, door, page_routes(pages) if tokens is None else ())


def _finder(atlas: Atlas) -> Found:
    """The map of a page: the first that is served, where no name is given."""

    def find(name: str | None) -> tuple[str, str, LanguageMap]:
        try:
            served = next(iter(atlas.maps.values())) if name is None else atlas.get(name)
        except (NoSuchMapError, StopIteration) as error:
            raise LookupError(str(error) or "no map is served yet") from error
        return served.name, served.version, served.world

    return find
