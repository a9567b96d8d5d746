"""Which language a question is in: by script, or by its commonest words and letters."""

import re
from collections.abc import Mapping
from functools import lru_cache

from lpslam.language.languages import LATIN
from lpslam.language.tables.knowledge import Knowledge
from lpslam.language.tables.patterns import standing
from lpslam.language.tables.words import is_mark

_KANA = standing(r"[\u3040-\u30ff]")
_HANGUL = standing(r"[\uac00-\ud7af]")
_HAN = standing(r"[\u4e00-\u9fff]")
_POSSESSIVE = standing(r"\w['’]s\b")
# Letters and turns that one language of Latin script has and the others do not.
_OWN_LETTERS = {
    "es": standing(r"[¿¡ñ]"),
    "de": standing(r"[ßäöü]", re.IGNORECASE),
    "fr": standing(r"[çœêèàùâîôë]|\b[jldnmtsc]['’]|\bqu['’]", re.IGNORECASE),
}
_RIVAL = 0.7  # a language with this share of the likeliest one's common words may be meant too
_KNOWN_SHARE = 0.3  # of the words of a sentence that are common in its language
_FEWEST_LATIN = 2  # common words of a language of Latin script beside other scripts: a sentence of it
_FEWEST_SURE, _LEAD = 3, 2.0  # common words of the one language of a text, and how many times those of another
_KANJI_ONLY = 8  # characters of Japanese that needs no kana: 薬局, 市役所; a sentence of Han letters alone is Chinese


@lru_cache(maxsize=256)
def _hits(text: str, knowledge: Knowledge) -> Mapping[str, float]:
    """How many words of a text are common in each language of Latin script, and how much its letters say so."""
    words = [unit for unit in knowledge.folder.units(text) if not is_mark(unit)]
    hits = {language: float(sum(word in knowledge.common[language] for word in words)) for language in LATIN}
    for language, letters in _OWN_LETTERS.items():
        if hits[language] and letters.search(text):
            hits[language] += 1.5
    if _POSSESSIVE.search(text):
        # “Nadia's” is a name as English has them; its “s” is a word in French.
        hits["en"] += 1.5
    return hits


def is_surely_one(text: str, knowledge: Knowledge) -> bool:
    """Whether a text of Latin script is in one language without doubt, so that it need not be read in others."""
    best, second = sorted(_hits(text, knowledge).values(), reverse=True)[:2]
    return best >= _FEWEST_SURE and best >= _LEAD * second


@lru_cache(maxsize=256)
def languages_of(text: str, knowledge: Knowledge) -> tuple[str, ...]:
    """Return the languages that a question may be in, likeliest first; none where it cannot be read.

    By script, and where that is Latin by the commonest words and letters; a question of a few words may be in any.
    """
    kana, hangul, han = (len(script.findall(text)) for script in (_KANA, _HANGUL, _HAN))
    words = [unit for unit in knowledge.folder.units(text) if not is_mark(unit)]
    latin = max(sum(len(word) > 1 and word in knowledge.common[language] for word in words) for language in LATIN)
    # A name of another script stands in a sentence: “Bring mich zu 岡本教授”.
    if kana + hangul + han and latin < _FEWEST_LATIN:
        if kana:
            return ("ja",)
        if hangul >= han:
            return ("ko",)
        return ("zh", "ja") if len(text) <= _KANJI_ONLY else ("zh",)
    hits = _hits(text, knowledge)
    ranked = sorted(LATIN, key=lambda language: -hits[language])
    if hits[ranked[0]] >= 2 or (hits[ranked[0]] and len(words) <= 3):
        return tuple(language for language in ranked if hits[language] >= _RIVAL * hits[ranked[0]])
    # A few words carry no grammar that could turn their meaning round; a whole sentence might.
    if len(words) <= 3:
        return tuple(ranked)
    return tuple(language for language in ranked[:1] if hits[language] >= _KNOWN_SHARE * len(words))


def wish_languages(text: str, knowledge: Knowledge) -> tuple[str, ...]:
    """Return the languages whose rules are tried, likeliest first; at least one."""
    likely = languages_of(text, knowledge)
    is_one = bool(likely) and (likely[0] not in LATIN or is_surely_one(text, knowledge))
    return likely if is_one else tuple(dict.fromkeys((*likely, *LATIN)))
