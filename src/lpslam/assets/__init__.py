"""Files that travel with the package: fonts (subsets of openly licensed ones, see fonts/licences)."""

from pathlib import Path

_FONTS = Path(__file__).parent / "fonts"


def font_path(name: str) -> Path:
    """The font file of a name; "map" is the general one (Latin, kana, simplified and common traditional Chinese).

    Raises:
        KeyError: there is no such font.
    """
    for suffix in (".ttf", ".otf"):
        path = _FONTS / f"{name}{suffix}"
        if path.is_file():
            return path
    raise KeyError(f"no font {name!r} in {_FONTS}")


def font_names(prefix: str = "") -> list[str]:
    """Names of the carried fonts that begin with a prefix ("latin", "chinese"), sorted."""
    return sorted(
        path.stem for path in _FONTS.iterdir() if path.suffix in (".ttf", ".otf") and path.stem.startswith(prefix)
    )
