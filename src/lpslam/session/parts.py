"""What a session is put together from."""

from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from functools import partial

from lpslam.camera import PinholeCamera
from lpslam.config import GroundConfig, ReadingConfig, SpottingConfig
from lpslam.ground.scans import Scans
from lpslam.language.model import LanguageModel
from lpslam.language.naming.beside import NamingBeside
from lpslam.language.offline import OfflineModel, embedded_model
from lpslam.mapfile.language_map import LanguageMap
from lpslam.priority import READING, yield_to_others
from lpslam.text.mapper import TextMapper
from lpslam.text.reading.reading_thread import ReadingThread
from lpslam.text.reading.spotting import PaddleSpotter, TextSpotter
from lpslam.text.reading.spotting_process import SpottingProcess


def naming_beside(language: LanguageModel | None) -> NamingBeside | None:
    """Mapping waits for no model but the embedded one; another's names come when they come."""
    if language is None or isinstance(language, OfflineModel):
        return None
    return NamingBeside(language, embedded_model())


def reading_thread(mapper: TextMapper, config: ReadingConfig, live: bool) -> ReadingThread:
    """Live, the newest frame is read first, and tracking comes first; of a recording none is left out."""
    if live:
        size, most = config.live_queue_size, config.live_queue_bytes
        return ReadingThread(mapper, size, config.live_share, READING, newest_first=True, queue_bytes=most)
    return ReadingThread(mapper, config.queue_size)


def scans_of(base: LanguageMap | None, camera: PinholeCamera, config: GroundConfig) -> Scans | None:
    """Those of the map that goes on, or new ones where the ground is wanted."""
    if base is not None and base.scans is not None:
        return base.scans
    return Scans(camera, config.width) if config.enabled else None


def opened_spotter(opened: ExitStack, config: SpottingConfig, live: bool) -> TextSpotter:
    """Who finds and reads text: live in a process of its own, if there can be one, which ends with `opened`."""
    if live and SpottingProcess.is_possible():
        return opened.enter_context(SpottingProcess(config))
    return load_spotter(config, READING if live else 0)


def load_spotter(config: SpottingConfig, niceness: int) -> PaddleSpotter:
    """The networks that find and read text."""
    # The engine's own threads are as patient as the thread that loads it.
    with ThreadPoolExecutor(1, initializer=partial(yield_to_others, niceness)) as loader:
        return loader.submit(PaddleSpotter, config).result()
