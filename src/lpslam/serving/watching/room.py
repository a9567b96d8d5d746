"""What watchers see of the room: made in a thread, when it has changed and somebody has asked since the last time."""

import base64
import json
import logging
import threading
from collections.abc import Callable
from typing import Any

from lpslam.config import WatchingConfig
from lpslam.page.pictures import RoomPicture
from lpslam.serving.watching.grown import Grown
from lpslam.serving.watching.pace import Pace

logger = logging.getLogger(__name__)

_LOOK_S = 0.2  # seconds between looks at whether something may be made
_LAST_S = 5.0  # seconds in which the last of it is made

Show = Callable[[str, dict[str, Any]], None]
"""Told the name of a part of the page, and what is new of it."""


class Room:
    """The room's picture for those who see it from above, and its points for those who see it in space.

    Who has asked for either is told when there is a newer one, and asks again.

    Args:
        grown: the map so far.
        limits: how often, and for which share of a core.

    Attributes:
        farewells: how many have asked for the last picture.
    """

    def __init__(self, grown: Grown, limits: WatchingConfig) -> None:
        self._grown, self._limits = grown, limits
        self._is_picture_wanted, self._are_points_wanted = threading.Event(), threading.Event()
        self._picture, self._drawn = b"", 0
        self.farewells = 0
        self._gone, self._is_done = threading.Event(), threading.Event()

    def start(self, show: Show) -> None:
        """Make both from now on, in a thread."""
        threading.Thread(target=self._make, args=(show,), name="lpslam-painting", daemon=True).start()

    def finish(self, *, is_watched: bool) -> None:
        """The run has ended: wait until the last of both is made for who watches; there will be no other."""
        if is_watched:
            self._is_picture_wanted.set()
            self._are_points_wanted.set()
        self._gone.set()
        self._is_done.wait(_LAST_S)

    def points(self, version: int) -> bytes:
        """What is new of the points since a version (`page.growing.GrowingPoints.since`); newer ones are made."""
        self._are_points_wanted.set()
        return self._grown.points_since(version)

    def picture(self, *, is_last: bool = False) -> bytes:
        """The picture as it was made last, as JSON; empty before there is one. A newer one is made.

        Args:
            is_last: whoever asks knows that the run has ended, and asks for nothing after it.
        """
        self._is_picture_wanted.set()
        self.farewells += is_last and self._gone.is_set()
        return self._picture

    def _make(self, show: Show) -> None:
        pace = Pace(self._limits.picture_s, self._limits.painting_share)
        # What is loaded or compiled at the first time is not what a picture costs.
        self._grown.anything(self._grown.config).picture()
        while not self._gone.wait(_LOOK_S):
            if self._is_any_wanted() and pace.is_due():
                with pace:
                    self._try_to_renew(show)
        if self._is_any_wanted():
            self._try_to_renew(show)
        self._is_done.set()

    def _is_any_wanted(self) -> bool:
        is_picture_old = self._grown.room > self._drawn
        return self._are_points_wanted.is_set() or (is_picture_old and self._is_picture_wanted.is_set())

    def _try_to_renew(self, show: Show) -> None:
        try:
            self._renew(show)
        except Exception as error:
            # The page goes on without.
            logger.warning("the room cannot be shown: %s", error)

    def _renew(self, show: Show) -> None:
        if self._are_points_wanted.is_set() and self._grown.update_points():
            self._are_points_wanted.clear()
            show("points", {})
        room = self._grown.room
        if room > self._drawn and self._is_picture_wanted.is_set():
            self._is_picture_wanted.clear()
            self._drawn = room
            picture = self._grown.picture()
            if picture is not None:
                self._picture = _as_json(picture)
                show("picture", {})


def _as_json(picture: RoomPicture) -> bytes:
    address = "data:image/png;base64," + base64.b64encode(picture.png).decode("ascii")
    return json.dumps({"picture": address, "extent": [round(each, 3) for each in picture.extent]}).encode("ascii")
