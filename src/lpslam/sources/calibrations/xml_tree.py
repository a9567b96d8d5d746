"""XML, such as OpenCV's FileStorage, as a tree of lower-case keys."""

from xml.etree import ElementTree

from lpslam.sources.yaml_tree import Tree

_MOST_LETTERS = 1 << 18
_DEEPEST = 30
_DECLARATIONS = ("<!doctype", "<!entity")


def tree_of_xml(text: str) -> Tree:
    """The tree of an XML text: elements and attributes by name, rows of numbers as lists.

    Raises:
        ValueError: one line that says why it is not read.
    """
    if len(text) > _MOST_LETTERS:
        raise ValueError(f"it has {len(text):,} letters, more than {_MOST_LETTERS:,}")
    if any(word in text.lower() for word in _DECLARATIONS):
        raise ValueError("it declares a document type or entities; leave these out")
    try:
        root = ElementTree.fromstring(text)
    except (ElementTree.ParseError, ValueError) as error:
        raise ValueError(" ".join(str(error).split())[:200]) from error
    value = _value(root, 0)
    return value if isinstance(value, dict) else {root.tag.lower(): value}


def _value(element: ElementTree.Element, depth: int) -> object:
    if depth > _DEEPEST:
        raise ValueError("it is nested too deeply")
    tree: Tree = {name.lower(): _plain(value) for name, value in element.attrib.items() if name != "type_id"}
    for child in element:
        tree.setdefault(child.tag.lower(), _value(child, depth + 1))
    return tree or _plain(element.text or "")


def _plain(text: str) -> object:
    words = text.split()
    try:
        numbers = [float(word) for word in words]
    except ValueError:
        return text.strip()
    return numbers[0] if len(numbers) == 1 else numbers
