"""Build the font subsets in src/lpslam/assets/fonts from Debian's font packages and two of npm's.

Get the packages into one folder first (no root needed), then run this script with that folder:

    apt-get download fonts-noto-cjk fonts-noto-cjk-extra fonts-droid-fallback fonts-lxgw-wenkai fonts-lato \
        fonts-roboto-unhinted fonts-roboto-slab fonts-open-sans fonts-bebas-neue fonts-lobster fonts-dancingscript \
        fonts-kaushanscript fonts-leckerli-one fonts-ebgaramond-extra fonts-vollkorn fonts-league-spartan \
        fonts-comfortaa fonts-yanone-kaffeesatz fonts-comic-neue fonts-play
    npm pack @fontsource/ma-shan-zheng @fontsource/zcool-kuaile
    python -m pip install fonttools
    python tools/build_fonts.py FOLDER

Each subset is renamed, as the Open Font License asks of modified versions with reserved names; the copyright and
licence entries inside the font stay, and the package's own copyright file goes to assets/fonts/licences.
"""

import subprocess
import sys
import tarfile
import tempfile
from pathlib import Path

from fontTools import subset
from fontTools.merge import Merger
from fontTools.ttLib import TTFont
from fontTools.ttLib.scaleUpem import scale_upem

from lpslam.simulation.boards import wording
from lpslam.simulation.lexicon import characters

OUT = Path(__file__).resolve().parents[1] / "src" / "lpslam" / "assets" / "fonts"
LATIN = "".join(map(chr, range(0x20, 0x7F))) + "·–—‘’“”…€£¥°©®é"

# Our name: (Debian package, file inside it, number within a collection).
LATIN_FONTS = {
    "latin-sans-bold": ("fonts-lato", "Lato-Bold.ttf", -1),
    "latin-sans-black": ("fonts-lato", "Lato-Black.ttf", -1),
    "latin-grotesque-bold": ("fonts-roboto-unhinted", "Roboto-Bold.ttf", -1),
    "latin-slab-bold": ("fonts-roboto-slab", "RobotoSlab-Bold.otf", -1),
    "latin-condensed-bold": ("fonts-open-sans", "OpenSans-CondBold.ttf", -1),
    "latin-poster": ("fonts-bebas-neue", "BebasNeue-Bold.otf", -1),
    "latin-script-bold": ("fonts-lobster", "lobster.otf", -1),
    "latin-script-brush": ("fonts-kaushanscript", "KaushanScript-Regular.otf", -1),
    "latin-script-fat": ("fonts-leckerli-one", "LeckerliOne-Regular.ttf", -1),
    "latin-script-light": ("fonts-dancingscript", "DancingScript-Bold.otf", -1),
    "latin-serif": ("fonts-ebgaramond-extra", "EBGaramond12-Regular.ttf", -1),
    "latin-serif-bold": ("fonts-vollkorn", "Vollkorn-Bold.ttf", -1),
    "latin-geometric-bold": ("fonts-league-spartan", "LeagueSpartan-Bold.otf", -1),
    "latin-round-bold": ("fonts-comfortaa", "Comfortaa-Bold.ttf", -1),
    "latin-narrow-bold": ("fonts-yanone-kaffeesatz", "YanoneKaffeesatz-Bold.otf", -1),
    "latin-comic-bold": ("fonts-comic-neue", "ComicNeue-Bold.otf", -1),
    "latin-square-bold": ("fonts-play", "Play-Bold.ttf", -1),
}
CHINESE_FONTS = {
    "chinese-hei-bold": ("fonts-noto-cjk", "NotoSansCJK-Bold.ttc", 2),
    "chinese-hei-black": ("fonts-noto-cjk-extra", "NotoSansCJK-Black.ttc", 2),
    "chinese-song-bold": ("fonts-noto-cjk", "NotoSerifCJK-Bold.ttc", 2),
    "chinese-kai-bold": ("fonts-lxgw-wenkai", "LXGWWenKai-Bold.ttf", -1),
}
# Cut into many files of a hundred characters each.
BRUSH_FONTS = {"chinese-brush": "ma-shan-zheng", "chinese-hand": "zcool-kuaile"}
MAP_FONT = {"map": ("fonts-droid-fallback", "DroidSansFallbackFull.ttf", -1)}
LATIN_OF_MAP = ("fonts-open-sans", "OpenSans-Regular.ttf")


def map_characters() -> str:
    """Latin, kana, punctuation, the GB2312 set and the more frequent half of Big5."""
    simplified = [bytes((high, low)) for high in range(0xA1, 0xF8) for low in range(0xA1, 0xFF)]
    lows = [*range(0x40, 0x7F), *range(0xA1, 0xFF)]
    traditional = [bytes((high, low)) for high in range(0xA4, 0xC7) for low in lows]
    cjk = "".join(code.decode("gb2312", errors="ignore") for code in simplified)
    cjk += "".join(code.decode("big5", errors="ignore") for code in traditional)
    kana = "".join(map(chr, range(0x3000, 0x3100)))
    accented = "".join(map(chr, range(0xA0, 0x180)))
    wide = "".join(map(chr, range(0xFF01, 0xFF5F)))
    return "".join(sorted(set(LATIN + accented + kana + wide + cjk + characters())))


def build(name: str, source: Path, number: int, text: str) -> Path:
    return build_into(OUT / f"{name}{source.suffix.replace('.ttc', '.otf')}", source, number, text)


def build_into(target: Path, source: Path, number: int, text: str) -> Path:
    font = TTFont(source, fontNumber=number, lazy=True)
    options = subset.Options(hinting=False, layout_features=["kern"], name_IDs=["*"], notdef_outline=True)
    options.drop_tables += [
        "GSUB",
        "GPOS",
        "GDEF",
        "kern",
        "feat",
        "morx",
        "vhea",
        "vmtx",
        "VORG",
        "BASE",
        "DSIG",
        "FFTM",
        "PfEd",
    ]
    tool = subset.Subsetter(options)
    tool.populate(text=text)
    tool.subset(font)
    family = f"Lpslam {target.name.split('.')[0]}"
    table = font["name"]
    table.names = [record for record in table.names if record.nameID in (0, 7, 8, 9, 10, 11, 12, 13, 14)]
    for record_id, value in ((1, family), (2, "Regular"), (3, family), (4, family), (6, family.replace(" ", "-"))):
        table.setName(value, record_id, 3, 1, 0x409)
    if "CFF " in font:
        cff = font["CFF "].cff
        cff.fontNames = [family.replace(" ", "-")]
        cff.topDictIndex[0].FullName = family
        cff.topDictIndex[0].FamilyName = family
    font.save(target)
    return target


def lend_latin(target: Path, source: Path) -> None:
    """Add the Latin letters of another font to one that has none (Droid Sans Fallback)."""
    present = TTFont(target).getBestCmap()
    borrowed = "".join(map(chr, [*range(0x20, 0x7F), *range(0xA0, 0x180), 0x20AC]))
    latin = target.with_suffix(".latin.ttf")
    build_into(latin, source, -1, "".join(letter for letter in borrowed if ord(letter) not in present))
    font = TTFont(latin)
    scale_upem(font, TTFont(target)["head"].unitsPerEm)
    font.save(latin)
    merged = Merger().merge([str(target), str(latin)])
    merged.save(target)
    latin.unlink()


def join(name: str, folder: Path, package: str, into: Path, text: str) -> Path:
    """One font of the pieces in an npm package that have characters of a text."""
    (archive,) = folder.glob(f"fontsource-{package}-*.tgz")
    with tarfile.open(archive) as tar:
        tar.extractall(into / package, filter="data")
    root = into / package / "package"
    (OUT / "licences" / f"fontsource-{package}.txt").write_bytes((root / "LICENSE").read_bytes())
    pieces, wanted = [], set(map(ord, text))
    for path in sorted((root / "files").glob("*-400-normal.woff")):
        font = TTFont(path)
        has = wanted & set(font.getBestCmap())
        wanted -= has
        if has:
            font.flavor = None
            tool = subset.Subsetter(subset.Options(hinting=False, layout_features=[], notdef_outline=True))
            tool.populate(unicodes=has)
            tool.subset(font)
            font.save(into / f"{path.stem}.ttf")
            pieces.append(str(into / f"{path.stem}.ttf"))
    whole = into / f"{name}.ttf"
    Merger().merge(pieces).save(whole)
    return build(name, whole, -1, text)


def report(target: Path, text: str) -> None:
    present = TTFont(target).getBestCmap()
    missing = [letter for letter in dict.fromkeys(text) if ord(letter) not in present]
    print(f"{target.name}: {target.stat().st_size // 1024} KiB, {len(present)} characters", end="")
    print(f", missing {''.join(missing[:60])!r}" if missing else "")


def unpack(folder: Path, package: str, into: Path) -> Path:
    root = into / package
    if not root.exists():
        (archive,) = folder.glob(f"{package}_*.deb")
        root.mkdir()
        subprocess.run(["dpkg", "-x", str(archive), str(root)], check=True)
        (licence,) = root.glob("usr/share/doc/*/copyright")
        (OUT / "licences" / f"{package}.txt").write_bytes(licence.read_bytes())
    return root


def main() -> None:
    folder = Path(sys.argv[1])
    (OUT / "licences").mkdir(parents=True, exist_ok=True)
    on_boards = "".join(sorted(set(LATIN + characters() + wording.characters())))
    groups = ((LATIN_FONTS, LATIN), (CHINESE_FONTS, on_boards), (MAP_FONT, map_characters()))
    with tempfile.TemporaryDirectory() as scratch:
        for fonts, text in groups:
            for name, (package, file, number) in fonts.items():
                source = next(unpack(folder, package, Path(scratch)).rglob(file))
                target = build(name, source, number, text)
                if name == "map":
                    lend_latin(target, next(unpack(folder, LATIN_OF_MAP[0], Path(scratch)).rglob(LATIN_OF_MAP[1])))
                report(target, text)
        for name, package in BRUSH_FONTS.items():
            report(join(name, folder, package, Path(scratch), on_boards), on_boards)


if __name__ == "__main__":
    main()
