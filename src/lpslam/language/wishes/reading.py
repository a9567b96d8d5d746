"""From a question to a `Wish`: one evaluator over the rows of each language's table."""

from collections.abc import Sequence
from dataclasses import replace

from lpslam.language.languages import LATIN, UNSPACED
from lpslam.language.questions.question import read_question
from lpslam.language.questions.speaking import languages_of, wish_languages
from lpslam.language.sanitise import clean_text
from lpslam.language.signs.hours import asked_time
from lpslam.language.tables.knowledge import Knowledge
from lpslam.language.tables.patterns import standing
from lpslam.language.tables.words import UNSPACED_RUN, is_mark
from lpslam.language.wishes.chains import (
    FEWEST_LISTED,
    are_things,
    chained,
    finer_pieces,
    lists_in,
    pieces_of,
    says_a_kind,
    says_a_place,
)
from lpslam.language.wishes.codes import asked_codes, identities
from lpslam.language.wishes.floors import floor_of
from lpslam.language.wishes.form import (
    LISTED,
    OF_ANY_PLACE,
    PREVIOUS,
    Ask,
    Identity,
    Relation,
    Sort,
    Stop,
    Which,
    Wish,
)
from lpslam.language.wishes.polarity import parted_by_clauses
from lpslam.language.wishes.rules import (
    LONGEST,
    Rules,
    ask_of,
    content_left,
    each_of,
    orders_of,
    person_of,
    relation_of,
    rules_of,
)
from lpslam.language.wishes.sorts import attributes_of

_ENDS = " .。!！?？,，、;；¿¡"
_MOST_STOPS = 6
_OPPOSED = {Which.NEAREST.value, Which.FARTHEST.value}  # one place is hardly both
_BESIDE = frozenset(map(str, (Relation.NEAR, Relation.BEFORE, Relation.NEXT_TO, Relation.OPPOSITE)))
"""Relations to a place at which people meet."""
_FEWEST_ALTERNATIVES = 2
_MOST_NAMED_WORDS = 7  # of an alternative: longer ones tell of something
_DEEPEST = 2  # anchors of anchors
_STANDING = (Relation.NEXT_TO, Relation.OPPOSITE, Relation.LEFT_OF, Relation.RIGHT_OF, Relation.BETWEEN)
"""Relations in which so little stands that they tell a place by themselves."""
_CLAUSE_END = standing(r"(?<=\w)(?:[:：](?=\s|[^\x00-\u2fff])|[.;](?=\s)|。)")  # it parts clauses as a comma does
_LAST_CLAUSE = standing(r"^(.*)[,，、](.*?)$")
_SIGHS = standing("[\u1100-\u11ff\u3131-\u318e]+")  # ㅠㅠ, ㅋㅋ: letters of Hangul that make no syllable
_TITLE = standing(r"\b(Dr|Dra|Prof|Mrs?|Ms|Sra?|Mme|St|med)\. ")  # its point ends no clause
_LATIN = standing("[A-Za-z]")
_GLOSS = standing(r"[\d\u3040-\u30ff\u3400-\u9fff\uac00-\ud7a3]+\s*\(((?=[^)]*[a-z])[A-Z][A-Za-z\d .&'’-]*)\)")
"""“2号拍卖场(Sale Ring 2)”: a name in brackets, in another script, is what the board says."""
_LAST_CODE = standing(r"(?<![^\W\d_])(?<!\d)(?:[A-Z]|\d+[A-Z]?)$")
_BARE_CODE = standing(r"(?:(?:the|la|el|le|der|die|das|dem|den) )?([A-Z]|\d+[A-Z]?)")
_POSSESSIVE = standing(r"['’]s?$")


def read_wish(question: str, knowledge: Knowledge) -> Wish:
    """Return what a question means; one stop with all its words where no rule says more."""
    text = _TITLE.sub(r"\1 ", _SIGHS.sub("", clean_text(question, LONGEST)).strip(_ENDS))
    languages = wish_languages(text, knowledge)
    language = next(iter(languages_of(text, knowledge)), None)
    alternatives = _among(text, languages, knowledge)
    plan = _plan(text, languages, knowledge) if alternatives is None else Wish((alternatives,), language)
    if plan is not None:
        return plan
    alone = _stop(text, languages, knowledge)
    is_plain = alone.relation is None and not alone.without and not alone.contradiction
    listed = _unordered(text, languages, knowledge) if is_plain and not parted_by_clauses(text, languages[0]) else []
    if listed:
        return Wish(_parts(listed, languages, knowledge, language), language, instead=Wish((alone,), language))
    cued = _cued(text, languages, knowledge) if is_plain and alone.ask not in LISTED else None
    if cued is not None:
        return Wish((cued,), language, instead=Wish((alone,), language))
    # “Remind me what they call the stall next to it”: words that are no place tell of whatever stands there.
    told = rules_of(languages[0])["spots"].sub(" ", alone.what)
    is_told = alone.relation in _STANDING and alone.what and not alone.identity
    if is_told and not says_a_kind(told, languages, knowledge):
        return Wish((alone,), language, instead=Wish((replace(alone, what=""),), language))
    # “Is there a chemist's inside the hospital?”: that is where the map is of.
    bare = rules_of(languages[0])["inside"].sub(" ", text) if alone.what else text
    other = None if bare == text else Wish((_stop(bare, languages, knowledge),), language)
    return Wish((alone,), language, instead=other)


def _cued(text: str, languages: tuple[str, ...], knowledge: Knowledge) -> Stop | None:
    """Read whatever stands beside a place that is all else the text tells of: a relation's word anywhere in it."""
    rules = rules_of(languages[0])
    found = rules.first("cues", text)
    if found is None:
        return None
    relation, rest = Relation(found[0].then["relation"]), " ".join(found[1].group("before", "after"))
    count, pieces = (2, rules["between"].split(rest)) if relation is Relation.BETWEEN else (1, [rest])
    parts = [each for each in pieces if content_left(each, rules)]
    anchors = tuple(_stop(each, languages, knowledge, depth=_DEEPEST) for each in parts)
    return Stop("", relation=relation, anchor=anchors, whole=text) if len(parts) == count else None


def _plan(text: str, languages: tuple[str, ...], knowledge: Knowledge) -> Wish | None:
    """Read stops that a text puts in order by a word for it: “first … then …”, 먼저 …고."""
    for language in languages:
        rules = rules_of(language)
        said = rules.resuming(text)
        found = rules.first("sequences", said)
        rest = _in_sequence(said, rules)
        is_ordered = language == languages[0] and rules["ordering"].search(said) is not None
        is_plan = is_ordered or len(rest) > 1
        parts = [each for part in rest for each in pieces_of(part, (language,), knowledge)] if is_plan else []
        is_sure = is_ordered or found is None or not found[0].then.get("perhaps")
        # Where the text may be one wish, whether there is such a place is for the map to say.
        says = sum(says_a_place(part, knowledge) if is_sure else bool(content_left(part, rules)) for part in parts)
        is_read = says >= max(2, len(parts) - 1)
        if len(parts) > 1 and (is_read or all(content_left(part, rules) for part in parts)):
            spoken = next(iter(languages_of(text, knowledge)), language if is_sure else None)
            alone = None if is_sure and is_read else Wish((_stop(text, languages, knowledge),), language)
            plan = Wish(_parts(parts, languages, knowledge, spoken), language, instead=alone)
            finer = [piece for part in parts for piece in finer_pieces(part, language)]
            if len(parts) < len(finer) <= _MOST_STOPS:
                return Wish(_parts(finer, languages, knowledge, spoken), language, instead=plan)
            return plan
    return None


def _parts(
    parts: Sequence[str], languages: tuple[str, ...], knowledge: Knowledge, language: str | None
) -> tuple[Stop, ...]:
    """Read parts of a text as stops, each in the language of the whole: “pay” alone is French as well."""
    return tuple(replace(_stop(part, languages, knowledge), language=language) for part in parts[:_MOST_STOPS])


def _unordered(text: str, languages: tuple[str, ...], knowledge: Knowledge) -> list[str]:
    """Things that are listed without a word for their order, three at least, each something of its own.

    Whether each is a place of its own is for the map to say.
    """
    chain = chained(text, languages)
    for pieces in (chain, *lists_in(text)):
        if not FEWEST_LISTED <= len(pieces) <= _MOST_STOPS:
            continue
        read = sum(are_things((piece,), knowledge) for piece in pieces)
        if are_things(pieces, knowledge) or (pieces is chain and read >= len(pieces) - 1):
            return pieces
    return []


def _among(text: str, languages: tuple[str, ...], knowledge: Knowledge) -> Stop | None:
    """Read which of several named places is the nearest, farthest or largest, to an anchor or from here."""
    for language in languages:
        rules = rules_of(language)
        found = rules.first("among", text)
        order, rank = (None, 1) if found is None else next(iter(orders_of(text, (language,))), (None, 1))
        if found is None or (order is None and "which" not in found[0].then):
            continue
        order = order or Which(found[0].then["which"])  # “离药房近的是A还是B”
        groups = {name: (value or "").strip(_ENDS) for name, value in found[1].groupdict().items()}
        listed = [groups.get("first", ""), groups.get("second", "")]
        if "among" in groups:
            listed = [
                rules["alternative_ends"].sub("", each.strip(_ENDS)) for each in rules["between"].split(groups["among"])
            ]
        named = [each for each in listed if content_left(each, rules)]
        if len(named) < _FEWEST_ALTERNATIVES or not all(len(each.split()) <= _MOST_NAMED_WORDS for each in named):
            continue
        anchor = groups.get("anchor") or groups.get("near", "")
        is_here = not anchor or rules["here"].match(anchor) is not None
        return Stop(
            "",
            which=order,
            rank=rank,
            relation=None if is_here else Relation.NEAR,
            anchor=() if is_here else (_anchor(anchor, languages, knowledge, rules, 0),),
            among=tuple(_anchor(each, languages, knowledge, rules, 0) for each in named),
            ask=Ask.WHICH,
            whole=text,
        )
    return None


def _in_sequence(text: str, rules: Rules) -> list[str]:
    found = rules.first("sequences", text)
    if found is None:
        return [text]
    _, match = found
    first, then = (match.group(name).strip(_ENDS) for name in ("first", "then"))
    if not content_left(first, rules) or not content_left(then, rules):
        return [text]
    return [*_in_sequence(first, rules), *_in_sequence(then, rules)]


def _stop(text: str, languages: tuple[str, ...], knowledge: Knowledge, depth: int = 0) -> Stop:
    """Read one stop: what is asked, what is left out, its relation and anchor, order, and what its board bears."""
    text = _GLOSS.sub(r"\1", text)
    asked, whole = asked_time(text) if depth == 0 else None, text
    text = text if asked is None else asked.rest
    ask, ask_language = ask_of(text, languages)
    rules = rules_of(ask_language)
    what, without, torn = _without(text, languages, knowledge, depth)
    placed = _placed(what, languages, knowledge, depth)
    stop, what = placed if placed is not None else (Stop(text), what)
    floor, bare, is_torn = floor_of(what, languages[0] if languages else None)
    unplaced, what = (what, bare) if floor is not None else ("", what)
    order, place = next(iter(orders_of(what, languages)), (None, 1))
    if order is not None and (stop.which is Which.ANY or place > 1):
        stop = replace(stop, which=order, rank=place)
    left = content_left(what, rules)
    is_placed = stop.relation is not None or asked is not None or floor is not None
    if is_placed or ask in (Ask.LIST, Ask.WHICH):
        # Its place tells which: “the room next to …”; “what is that next to …” has common words only.
        left = content_left(rules["any"].sub(" ", what), rules)
    # “Where does one eat at noon?” says what is wanted in common words.
    if is_placed and (asked is None or not says_a_kind(what, languages, knowledge, 0.0)):
        left = _uncommon(left, languages, knowledge)
    if ask is Ask.WHICH and stop.relation is not None and not says_a_kind(what, languages, knowledge):
        left = ""
    is_any = ask in OF_ANY_PLACE or (not left and (is_placed or ask is Ask.LIST))
    which = stop.which
    opposed = sorted({each.value for each, _ in orders_of(what, languages)} & _OPPOSED)
    if which is Which.ANY and ask in LISTED:
        which = Which.ALL
    return replace(
        stop,
        what="" if is_any else what,
        without=without,
        identity=_identity(unplaced, languages) if floor is not None else () if is_any else _identity(what, languages),
        ask=ask,
        whole=whole,
        which=which,
        at=() if asked is None else asked.minutes,
        floor=floor,
        unplaced=unplaced,
        contradiction=" and ".join(opposed) if len(opposed) > 1 else "two floors" if is_torn else torn,
    )


def _placed(text: str, languages: tuple[str, ...], knowledge: Knowledge, depth: int) -> tuple[Stop, str] | None:
    """Read where a stop is said to stand; return it with its relation, and what is wanted there."""
    text = _CLAUSE_END.sub(",", text)
    for language in languages:
        text = rules_of(language)["unsaid"].sub("", text)
    relation = relation_of(text, languages) if depth < _DEEPEST else None
    if relation is None:
        return None
    row, match, rules = relation
    groups = {name: (value or "").strip(_ENDS) for name, value in match.groupdict().items()}
    what = " ".join(each for each in (groups.get(name, "") for name in ("what", "thing", "rest")) if each)
    before = _LAST_CLAUSE.match(what) if depth == 0 and rules["previous"].match(groups["anchor"]) else None
    if before is not None:
        # “I look at the bakery; what is left of it?”
        groups["anchor"], what = before.groups()
    groups["second"] = _of_the_same(groups["anchor"], groups.get("second", ""))
    anchors = tuple(
        _anchor(groups[name], languages, knowledge, rules, depth) for name in ("anchor", "second") if groups.get(name)
    )
    is_beside = row.then["relation"] in _BESIDE and len(anchors) == 1 and anchors != (PREVIOUS,)
    said = text.replace(groups.get("anchor", ""), "")
    if row.then["relation"] == Relation.ON_THE_WAY and not what and len(anchors) == 1:
        # “On the way to the bank” and no more.
        return Stop(text), groups["anchor"]
    is_met = rules["meeting"].search(said) is not None
    if row.then["relation"] == Relation.BEFORE and is_beside:
        is_met = is_met or any(each.sort is Sort.PERSON for each in anchors[0].identity)
    if is_beside and is_met and not says_a_kind(what, languages, knowledge):
        # “Let's meet in front of the bank”, “I am to appear before Mrs Kessab”.
        return Stop(text), groups["anchor"]
    rank = rules.ranks.get(groups.get("rank", "").casefold(), 1)
    is_here = len(anchors) == 1 and rules["here"].match(groups.get("anchor", ""))
    start = _anchor(groups["start"], languages, knowledge, rules, depth) if groups.get("start") else None
    stop = Stop(
        what,
        relation=None if is_here else Relation(row.then["relation"]),
        anchor=() if is_here else anchors,
        which=Which(row.then.get("which", "nearest" if is_here else "any")),
        rank=rank,
        start=start,
        same_side=bool(groups.get("side")),
    )
    return stop, what


def _of_the_same(first: str, second: str) -> str:
    """The second of two anchors; where it is a letter or number alone, what the first is: “between arms A and C”."""
    code, bare = _LAST_CODE.search(first), _BARE_CODE.fullmatch(second)
    return second if code is None or bare is None else first[: code.start()] + bare.group(1)


def _without(
    text: str, languages: tuple[str, ...], knowledge: Knowledge, depth: int
) -> tuple[str, tuple[Stop, ...], str]:
    """Part a text from what it leaves out: one place of the same kind, the nearest one, one by its code or place.

    Kinds and names that are refused are left to `read_question`. The last part is what is wanted and left out at once.
    """
    for language in languages[:1] if depth == 0 else ():
        found = rules_of(language).first("exclusions", text)
        if found is None:
            continue
        what, out = (found[1].group(name).strip(_ENDS) for name in ("what", "not"))
        numbered = _numbered_alike(what, out)
        if numbered:
            return what, numbered, ""
        if _is_the_same(what, out, languages, knowledge):
            return what, (), f"{what} and not {out}"
        stop = _stop(out, languages, knowledge, depth=_DEEPEST - 1)
        asked, left = (dict(read_question(each, knowledge).wanted) for each in (what, out))
        whole = read_question(text, knowledge)
        # “Not in a large chain” tells no place from another.
        is_told = bool(attributes_of(out)) and all("/" in each or each in asked for each in whole.refused)
        is_ordered = stop.which is not Which.ANY or stop.relation is not None or stop.floor is not None
        is_one = is_ordered or bool(stop.identity) or is_told
        is_read = bool(whole.wanted and whole.refused) and not is_one
        is_unread = bool(whole.wanted and left) and not whole.refused
        if (asked or is_told) and not is_read and (is_one or asked.keys() & left.keys() or is_unread):
            if is_told and not (stop.identity or is_ordered):
                # “The lounge that isn't the blue one”, “changing rooms, but not those for women”.
                return what, tuple(replace(stop, what=f"{what} {each}") for each in each_of(out)), ""
            if is_one:
                return what, (replace(stop, what=what) if not left and not stop.identity else stop,), ""
            # “Neither the piano nor the violin” are two places.
            return what, tuple(_stop(each, languages, knowledge, _DEEPEST - 1) for each in each_of(out)), ""
    parts = parted_by_clauses(text, languages[0]) if depth == 0 and languages else None
    told = [_told_alike(parts[0], each, languages) for each in parts[1]] if parts else []
    if parts is not None and all(told) and not asked_codes(parts[0]):
        # “A lecture theatre, not G01, the other one”; “the doctor, not Dr Lee”.
        return parts[0], tuple(stop for each in told for stop in each), ""
    return text, (), ""


def _is_the_same(what: str, out: str, languages: tuple[str, ...], knowledge: Knowledge) -> bool:
    """Whether what is left out is just what is wanted: “gate 23, but not gate 23”."""
    asked, left = (
        set(_uncommon(content_left(each, rules_of(languages[0])), languages, knowledge).split()) for each in (what, out)
    )
    is_ordered = bool(orders_of(out, languages)) or relation_of(out, languages) is not None
    return (
        bool(left)
        and left <= asked
        and not is_ordered
        and identities(asked_codes(what)) == identities(asked_codes(out))
    )


def _numbered_alike(what: str, out: str) -> tuple[Stop, ...]:
    """What is left out by its number alone, which is of what is asked for: “any dock except 1, 2 and 3”."""
    asked = asked_codes(what)
    codes = [code for code in asked_codes(f"{what} {out}") if code not in asked]
    return tuple(Stop(f"{what} {out}", identity=(identity,), whole=out) for identity in identities(codes))


def _told_alike(what: str, out: str, languages: tuple[str, ...]) -> tuple[Stop, ...]:
    """What is left out by its number or letter, or by the person whom it names."""
    if person_of(out, languages) is not None:
        return (Stop(out, identity=_identity(out, languages), whole=out),)
    return _numbered_alike(what, out)


def _uncommon(text: str, languages: tuple[str, ...], knowledge: Knowledge) -> str:
    """Return what of a text is more than the common words of its language: “comes”, “lo que hay”."""
    common = knowledge.common.get(languages[0], frozenset()) if languages else frozenset()
    return " ".join(unit for unit in knowledge.folder.units(text) if unit not in common and not is_mark(unit))


def _anchor(text: str, languages: tuple[str, ...], knowledge: Knowledge, rules: Rules, depth: int) -> Stop:
    if rules["previous"].match(text):
        return PREVIOUS
    stop = _stop(text, languages, knowledge, depth=depth + 1)
    is_stood_at = stop.relation is Relation.BEFORE and not stop.what and not depth  # “in front of X, what is left?”
    return stop.anchor[0] if is_stood_at else replace(stop, ask=Ask.WHERE)


def _identity(text: str, languages: tuple[str, ...]) -> tuple[Identity, ...]:
    # “Bring mich zu 岡本教授”; but any Chinese is Japanese to a rule of Japanese.
    others = [each for each in UNSPACED if each != "ja" or languages[:1] != ("zh",)]
    others += LATIN if _LATIN.search(text) else ()
    person = person_of(text, dict.fromkeys((*languages, *others) if UNSPACED_RUN.search(text) else languages))
    persons = () if person is None else (Identity(Sort.PERSON, _POSSESSIVE.sub("", person)),)
    return (*persons, *identities(asked_codes(text)))
