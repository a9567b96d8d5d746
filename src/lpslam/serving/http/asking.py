"""A question as it comes in, and as the core takes it."""

from lpslam.errors import UserError
from lpslam.serving import records
from lpslam.serving.questions import Asked, wish_text


def asked_of(body: records.Question | records.Destination, longest: int) -> Asked:
    """A question as the core takes it.

    Args:
        body: as it came in.
        longest: letters that a question may have.

    Raises:
        UserError: it is longer, or a wish in it is none.
    """
    position = None if body.position is None else tuple(body.position)
    if isinstance(body, records.Question):
        wish, before_wish = (None if each is None else wish_text(each) for each in (body.wish, body.before_wish))
        asked = Asked(body.question, body.before, position, body.heading, tuple(body.excluded), wish, before_wish)
    else:
        asked = Asked(body.question or "", None, position, body.heading)
    if max(len(asked.question), len(asked.before or "")) > longest:
        raise UserError(f"a question may have {longest:,} letters")
    return asked
