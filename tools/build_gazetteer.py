"""Build the gazetteer of the embedded language model from two openly licensed npm packages.

    python tools/build_gazetteer.py            # fetches both packages with `npm pack`, then builds
    python tools/build_gazetteer.py --packages DIR   # builds from *.tgz files that are already there

Sources: name-suggestion-index (BSD-3-Clause): brands with their kinds and cuisines; @openstreetmap/id-tagging-schema
(ISC): kinds of place with their names in many languages. Their licences are written beside the table.
"""

import argparse
import json
import lzma
import re
import subprocess
import tarfile
import tempfile
from collections import defaultdict
from pathlib import Path
from typing import Any

PACKAGES = ("name-suggestion-index@8.0.20260918", "@openstreetmap/id-tagging-schema@7.2.0")
DATA = Path(__file__).parents[1] / "src" / "lpslam" / "language" / "data"
LANGUAGES = ("en", "zh-CN", "zh-TW", "zh-HK", "ja", "ko", "es", "de", "fr", "it", "pt", "ru")

# What a person may be looking for in a building or a street; road furniture, pipelines and fields are left out.
_PLACE = re.compile(r"^(shop|amenity|healthcare|tourism|office|leisure|emergency|craft)(/|$)")
_PLACES_ELSEWHERE = {
    "highway/elevator", "highway/steps", "highway/bus_stop", "railway/station", "railway/subway_entrance",
    "entrance", "indoor/room", "railway/tram_stop", "aeroway/aerodrome", "aeroway/gate", "public_transport/platform",
}  # fmt: skip
_LEFT_OUT = re.compile(
    r"^(leisure/(pitch|track|fitness_station|nature_reserve|slipway|marina)|amenity/(recycling/|hunting|grit|lavoir|shelter/)"
    r"|tourism/(artwork/|camp|caravan|wilderness|trail)|emergency/(fire_hydrant|water|mountain|landing|lifeboat)"
    r"|shop/(vacant|yes|erotic/)|healthcare/yes|office/yes|amenity/(stripclub|swingerclub|love_hotel|brothel))"
)
_BRANDS_LEFT_OUT = re.compile(r"/(totem|billboard|atm|charge_point|vending_machine|payment_terminal|street_cabinet)$")
_NAME_TAG = re.compile(r"^(name|brand|short_name|alt_name|official_name)(:(en|zh|zh-Hans|zh-Hant|ja|ko|de|fr|es))?$")


def pack(folder: Path) -> None:
    for package in PACKAGES:
        subprocess.run(["npm", "pack", "--silent", package], cwd=folder, check=True)


def member(folder: Path, package: str, path: str) -> bytes:
    archive = next(folder.glob(f"{package}*.tgz"))
    with tarfile.open(archive) as tar:
        stream = tar.extractfile(f"package/{path}")
        assert stream is not None
        return stream.read()


def read_kinds(folder: Path) -> tuple[list[str], dict[str, dict[str, list[str]]]]:
    """Kinds of place and, for each kind, its names by language."""
    schema = "openstreetmap-id-tagging-schema"
    presets = json.loads(member(folder, schema, "dist/presets.json"))
    kinds = sorted(
        kind
        for kind, preset in presets.items()
        if (_PLACE.match(kind) or kind in _PLACES_ELSEWHERE)
        and not _LEFT_OUT.match(kind)
        and not preset.get("locationSet")
        and preset.get("searchable", True)
    )
    names: dict[str, dict[str, list[str]]] = defaultdict(dict)
    for language in LANGUAGES:
        tree = json.loads(member(folder, schema, f"dist/translations/{language}.json"))
        translated = tree[language]["presets"]["presets"]
        for kind in kinds:
            entry = translated.get(kind, {})
            painted = [entry["name"], *entry.get("aliases", [])] if entry.get("name") else []
            names[kind][language] = list(dict.fromkeys(s.strip() for s in painted))
    return kinds, names


def read_brands(folder: Path) -> list[list[Any]]:
    """Brands as [names joined by "|", kinds, cuisines], one row for each real-world brand."""
    index = json.loads(member(folder, "name-suggestion-index", "dist/json/nsi.json"))["nsi"]
    rows: dict[str, tuple[dict[str, None], dict[str, None], dict[str, None]]] = {}
    for path, group in index.items():
        tree, _, kind = path.partition("/")
        if tree != "brands" or _BRANDS_LEFT_OUT.search(path) or not _PLACE.match(kind):
            continue
        for item in group["items"]:
            tags = item["tags"]
            row = rows.setdefault(tags.get("brand:wikidata", item["id"]), ({}, {}, {}))
            for tag, value in tags.items():
                if _NAME_TAG.match(tag):
                    for name in value.split(";"):
                        row[0].setdefault(name.strip().replace("|", " "))
            row[1].setdefault(kind)
            for cuisine in tags.get("cuisine", "").split(";"):
                if cuisine:
                    row[2].setdefault(cuisine)
    return sorted(["|".join(names), list(kinds), list(cuisines)] for names, kinds, cuisines in rows.values())


def build(folder: Path) -> None:
    kinds, names = read_kinds(folder)
    table = {
        "names": {
            language: {kind: "|".join(names[kind][language]) for kind in kinds if names[kind][language]}
            for language in LANGUAGES
        },
        "brands": read_brands(folder),
    }
    raw = json.dumps(table, ensure_ascii=False, separators=(",", ":")).encode()
    packed = lzma.compress(raw, preset=9 | lzma.PRESET_EXTREME)
    (DATA / "gazetteer.json.xz").write_bytes(packed)
    licences = DATA / "licences"
    licences.mkdir(parents=True, exist_ok=True)
    for package, name in (
        ("name-suggestion-index", "name-suggestion-index-BSD-3-Clause.md"),
        ("openstreetmap-id-tagging-schema", "id-tagging-schema-ISC.md"),
    ):
        (licences / name).write_bytes(member(folder, package, "LICENSE.md"))
    print(f"{len(kinds)} kinds, {len(table['brands'])} brands, {len(raw)} bytes, packed {len(packed)} bytes")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--packages", type=Path, help="folder with the two packages as *.tgz")
    given = parser.parse_args().packages
    if given:
        build(given)
        return
    with tempfile.TemporaryDirectory() as temporary:
        pack(Path(temporary))
        build(Path(temporary))


if __name__ == "__main__":
    main()
