"""Build the gazetteer of the embedded language model from openly licensed npm packages.

    pip install wordfreq==3.1.1
    python tools/build_gazetteer.py            # fetches the packages with `npm pack`, then builds
    python tools/build_gazetteer.py --packages DIR   # builds from *.tgz files that are already there

Sources: name-suggestion-index (BSD-3-Clause): brands with their kinds and cuisines; @openstreetmap/id-tagging-schema
(ISC): kinds of place with their names and search terms in many languages; cldr-annotations-full (Unicode-3.0): names
of things in many languages. Their licences are written beside the table.

Search terms and names of things that are everyday words ("play", "used", "hard") say nothing sure and are left out,
but for those of `kept_words.json`; how common a word is comes from wordfreq.

What is looked up is folded here (`Folder.phrase`, `Folder.key`), so that the package only reads it.
"""

import argparse
import json
import lzma
import math
import re
import subprocess
import tarfile
import tempfile
from collections import defaultdict
from pathlib import Path
from typing import Any

from wordfreq import get_frequency_dict

from lpslam.language.tables.words import Folder

PACKAGES = (
    "name-suggestion-index@8.0.20260918",
    "@openstreetmap/id-tagging-schema@7.2.0",
    "cldr-annotations-full@48.2.0",
)
DATA = Path(__file__).parents[1] / "src" / "lpslam" / "language" / "data"
LEXICON = DATA / "lexicon"
# Languages in which questions are asked, as the sources call them.
ASKED = {"en": "en", "zh": "zh-CN", "zh-TW": "zh-TW", "ja": "ja", "ko": "ko", "es": "es", "de": "de", "fr": "fr"}
CLDR = {"en": "en", "zh": "zh", "zh-TW": "zh-Hant", "ja": "ja", "ko": "ko", "es": "es", "de": "de", "fr": "fr"}
# A search term that stands beside more kinds than this says nothing sure.
_MOST_KINDS = 2
# From how often in a thousand million words a term is an everyday word; by its logarithm.
_EVERYDAY = 3.8
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


def everyday_words(fold: Folder) -> dict[str, set[str]]:
    """Everyday words by language, as phrases, without those that are kept."""
    kept = json.loads(Path(__file__).with_name("kept_words.json").read_text("utf-8"))
    found: dict[str, set[str]] = {}
    for asked in ASKED:
        shares: dict[str, float] = defaultdict(float)
        for word, share in get_frequency_dict(asked.partition("-")[0]).items():
            shares[fold.phrase(word)] += share
        words = {phrase for phrase, share in shares.items() if math.log10(share) + 9 >= _EVERYDAY}
        found[asked] = words - {fold.phrase(word) for word in kept[asked].split("|")}
    return found


def read_terms(
    folder: Path, kinds: list[str], fold: Folder, everyday: dict[str, set[str]]
) -> dict[str, dict[str, list[str]]]:
    """Search terms by language and kind, as phrases; those that stand beside many kinds are left out."""
    terms: dict[str, dict[str, list[str]]] = {}
    for asked, language in ASKED.items():
        tree = json.loads(member(folder, "openstreetmap-id-tagging-schema", f"dist/translations/{language}.json"))
        translated = tree[language]["presets"]["presets"]
        owners: dict[str, list[str]] = defaultdict(list)
        for kind in kinds:
            # Their terms are parts of the body and ailments: words with which other things are wanted too.
            if kind.startswith(("amenity/doctors", "healthcare")):
                continue
            for term in translated.get(kind, {}).get("terms", []):
                phrase = fold.phrase(term)
                is_short = len(phrase) > 2 and phrase.count(" ") < 8
                if is_short and phrase not in everyday[asked] and kind not in owners[phrase]:
                    owners[phrase].append(kind)
        for phrase, found in owners.items():
            # A kind and its own kinds (shop/clothes and shop/clothes/suits) count as one.
            tops = [kind for kind in found if not any(kind.startswith(f"{other}/") for other in found)]
            if len(tops) <= _MOST_KINDS:
                for kind in tops:
                    terms.setdefault(asked, {}).setdefault(kind, []).append(phrase)
    return terms


def read_things(folder: Path, fold: Folder, everyday: dict[str, set[str]]) -> dict[str, dict[str, list[str]]]:
    """Names of things by language and concept, as phrases; a keyword only where all its things are of one concept."""
    concepts = {
        name: concept
        for concept, joined in json.loads(Path(__file__).with_name("thing_concepts.json").read_text("utf-8")).items()
        for name in joined.split("|")
    }
    trees = {
        asked: json.loads(member(folder, "cldr-annotations-full", f"annotations/{language}/annotations.json"))[
            "annotations"
        ]["annotations"]
        for asked, language in CLDR.items()
    }
    english = {sign: entry["tts"][0] for sign, entry in trees["en"].items() if entry.get("tts")}
    things: dict[str, dict[str, list[str]]] = {}
    for asked, tree in trees.items():
        owners: dict[str, set[str | None]] = defaultdict(set)
        for sign, entry in tree.items():
            concept = concepts.get(english.get(sign, ""))
            for text in [*entry.get("tts", []), *entry.get("default", [])]:
                owners[fold.phrase(text)].add(concept)
        for sign, entry in tree.items():
            concept = concepts.get(english.get(sign, ""))
            if concept is None:
                continue
            own = {fold.phrase(text) for text in entry.get("tts", [])}
            texts = [*entry.get("tts", []), *entry.get("default", [])]
            for phrase in dict.fromkeys(map(fold.phrase, texts)):
                is_sure = phrase in own or owners[phrase] == {concept}
                if len(phrase) > 2 and is_sure and phrase not in everyday[asked]:
                    things.setdefault(asked, {}).setdefault(concept, []).append(phrase)
    return things


def build(folder: Path) -> None:
    """Write the table and the licences."""
    han = json.loads((LEXICON / "han.json").read_text("utf-8"))
    fold = Folder(han["traditional"], han["simplified"], han["lookalikes"])
    everyday = everyday_words(fold)
    kinds, names = read_kinds(folder)
    brands = read_brands(folder)
    table = {
        "names": {
            language: {
                kind: [[text, fold.phrase(text), fold.key(text)] for text in names[kind][language]]
                for kind in kinds
                if names[kind][language]
            }
            for language in LANGUAGES
        },
        "terms": _joined(read_terms(folder, kinds, fold, everyday)),
        "things": _joined(read_things(folder, fold, everyday)),
        "brands": [
            [joined, "|".join(fold.key(name) for name in joined.split("|")), found, cuisines]
            for joined, found, cuisines in sorted(brands, key=lambda row: (-row[0].count("|"), row))
        ],
    }
    raw = json.dumps(table, ensure_ascii=False, separators=(",", ":")).encode()
    packed = lzma.compress(raw, preset=9 | lzma.PRESET_EXTREME)
    (DATA / "gazetteer.json.xz").write_bytes(packed)
    licences = DATA / "licences"
    licences.mkdir(parents=True, exist_ok=True)
    for package, path, name in (
        ("name-suggestion-index", "LICENSE.md", "name-suggestion-index-BSD-3-Clause.md"),
        ("openstreetmap-id-tagging-schema", "LICENSE.md", "id-tagging-schema-ISC.md"),
        ("cldr-annotations-full", "LICENSE", "cldr-annotations-Unicode-3.0.txt"),
    ):
        (licences / name).write_bytes(member(folder, package, path))
    print(f"{len(kinds)} kinds, {len(brands)} brands, {len(raw)} bytes, packed {len(packed)} bytes")


def _joined(tables: dict[str, dict[str, list[str]]]) -> dict[str, dict[str, str]]:
    return {
        language: {concept: "|".join(dict.fromkeys(phrases)) for concept, phrases in table.items()}
        for language, table in tables.items()
    }


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
