"""What the routes share: maps, who answers, events and jobs, and the time in which they live."""

import asyncio
import contextlib
import gc
import logging
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from pathlib import Path

from lpslam.config import Config
from lpslam.language.model import LanguageModel
from lpslam.language.offline import embedded_model
from lpslam.serving.answerers import Answerer
from lpslam.serving.atlas import Atlas, ServedMap
from lpslam.serving.corrections import Editor
from lpslam.serving.ground import Grounds
from lpslam.serving.hub import Hub
from lpslam.serving.jobs.queue import Jobs
from lpslam.serving.pictures import Pictures

logger = logging.getLogger(__name__)


@dataclass(slots=True)
class Services:
    """All that routes use.

    Raises:
        UserError: uploads cannot be kept.

    Attributes:
        atlas: the maps.
        answerer: answers questions.
        hub: tells of events.
        config: limits, and thresholds of the maps that jobs make.
        uploads: folder for uploads; None where none are taken.
        jobs: of the uploads; None where none are taken.
        language: judges names that a person gives.
        editor: corrects maps.
        pictures, grounds: of the maps.
        answers_later: whether whoever answers may begin beside the first requests; else questions are answered from the
            first request on.
    """

    atlas: Atlas
    answerer: Answerer
    hub: Hub
    config: Config
    uploads: Path | None = None
    jobs: Jobs | None = None
    language: LanguageModel = field(default_factory=embedded_model)
    editor: Editor = field(init=False)
    pictures: Pictures = field(default_factory=Pictures)
    grounds: Grounds = field(init=False)
    answers_later: bool = False

    def __post_init__(self) -> None:
        """Have a place for uploads, where they are taken."""
        self.grounds, self.editor = Grounds(self.config), Editor(self.atlas, self.language)
        if self.uploads is not None:
            self.jobs = Jobs(self.uploads, self.config, self.atlas, self.hub, self.on_map)

    @asynccontextmanager
    async def running(self) -> AsyncIterator[None]:
        """From the first request to the last."""
        starting = asyncio.create_task(self._start_answers())
        if not self.answers_later:
            await starting
        if self.jobs is not None:
            self.jobs.start()
        # Maps and programs stay: the collector need not go through them while somebody waits.
        gc.collect()
        gc.freeze()
        looking = asyncio.create_task(self._look())
        try:
            yield
        finally:
            for task in (starting, looking):
                task.cancel()
                # What went wrong in it is logged.
                with contextlib.suppress(asyncio.CancelledError, Exception):
                    await task
            if self.jobs is not None:
                await self.jobs.close()
            await self.answerer.close()

    async def _start_answers(self) -> None:
        try:
            await self.answerer.start(self.atlas.maps.values())
        except Exception as error:
            logger.error("no questions can be answered: %s", error or type(error).__name__)
            raise

    async def _look(self) -> None:
        """Serve maps anew whose files were replaced."""
        while True:
            await asyncio.sleep(self.config.serving.look_s)
            try:
                for served in await asyncio.to_thread(self.atlas.refresh):
                    await self.on_map(served)
            except Exception as error:
                # A map that cannot be served anew is served as it was; the next look tries again.
                logger.warning("maps could not be looked at: %s", error)

    async def on_map(self, served: ServedMap) -> None:
        """Have a new version of a map known to all."""
        await self.answerer.know(served)
        facts = {"name": served.name, "version": served.version, "landmarks": len(served.records)}
        self.hub.tell("map", facts)
