"""Which threads come first when there are more than cores: tracking, then mapping, then reading."""

import os
import sys
import threading
from contextlib import suppress

# Steps of niceness: mapping waits for tracking, reading for both. Twice as many for mapping made tracking slower: it
# waits for a lock or the interpreter that mapping holds and does not come to give back.
MAPPING, READING = 5, 10


def yield_to_others(niceness: int) -> None:
    """Let the calling thread, and those that it starts, run where others leave processor time; on Linux alone."""
    if sys.platform == "linux":
        with suppress(OSError):
            os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), niceness)
