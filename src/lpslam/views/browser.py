"""The person's browser, where there is a screen to show it."""

import os
import sys
import threading
import webbrowser


def open_browser(url: str) -> None:
    """Show an address in the browser; nothing where there is none, or no screen. Does not wait for it.

    Without a screen `webbrowser` would start a browser of the terminal, which takes the keyboard.
    """
    has_screen = sys.platform in ("win32", "darwin") or any(os.environ.get(v) for v in ("DISPLAY", "WAYLAND_DISPLAY"))
    if has_screen:
        threading.Thread(target=webbrowser.open, args=(url,), name="lpslam-browser", daemon=True).start()
