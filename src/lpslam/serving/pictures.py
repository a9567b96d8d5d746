"""Pictures of served maps, drawn once for each version."""

import tempfile
import threading
from pathlib import Path

from lpslam.serving.atlas import ServedMap


class Pictures:
    """Maps from above as PNG; safe in threads."""

    def __init__(self) -> None:
        self._drawing = threading.Lock()
        self._drawn: dict[str, tuple[str, bytes]] = {}

    def of(self, served: ServedMap) -> bytes:
        """The picture of a map."""
        from lpslam.views.pictures import draw_language_map

        # One at a time: drawing takes a second, and a flood must not take all threads.
        with self._drawing:
            version, drawn = self._drawn.get(served.name, ("", b""))
            if version != served.version:
                with tempfile.TemporaryDirectory(prefix="lpslam-") as folder:
                    out = Path(folder) / "map.png"
                    draw_language_map(served.world, out)
                    drawn = out.read_bytes()
                self._drawn[served.name] = served.version, drawn
        return drawn
