"""What a session is put together from."""

from concurrent.futures import ThreadPoolExecutor
from functools import partial

from lpslam.config import ReadingConfig, SpottingConfig
from lpslam.language.model import LanguageModel
from lpslam.language.naming.beside import NamingBeside
from lpslam.language.offline import OfflineModel
from lpslam.priority import READING, yield_to_others
from lpslam.text.mapper import TextMapper
from lpslam.text.reading.reading_thread import ReadingThread
from lpslam.text.reading.spotting import PaddleSpotter


def naming_beside(language: LanguageModel | None) -> NamingBeside | None:
    """Mapping waits for no model but the embedded one; another's names come when they come."""
    if language is None or isinstance(language, OfflineModel):
        return None
    return NamingBeside(language, OfflineModel())


def reading_thread(mapper: TextMapper, config: ReadingConfig, live: bool) -> ReadingThread:
    """Live, the newest frame is read, and tracking comes first; of a recording none is left out."""
    if live:
        return ReadingThread(mapper, 1, config.live_share, READING)
    return ReadingThread(mapper, config.queue_size)


def load_spotter(config: SpottingConfig, niceness: int) -> PaddleSpotter:
    """The networks that find and read text."""
    # The engine's own threads are as patient as the thread that loads it.
    with ThreadPoolExecutor(1, initializer=partial(yield_to_others, niceness)) as loader:
        return loader.submit(PaddleSpotter, config).result()
