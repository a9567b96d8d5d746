"""Thresholds of navigation: which places serve well enough, and how places stand to one another."""

from lpslam.config.section import Field, Section


class NavigationConfig(Section):
    """A wish answered by the places of a map."""

    # Shares of the best place's score: from which a place serves as well, and the nearer of the two is chosen; ...
    equal_share: float = Field(default=0.97, gt=0, le=1)
    # ... from which it serves well enough to be the nearest, the largest or in a relation that are asked for; ...
    nearly_share: float = Field(default=0.8, gt=0, le=1)
    # ... and from which it is in a list of all.
    serves_share: float = Field(default=0.6, gt=0, le=1)
    # Most places of a list.
    listed: int = Field(default=50, ge=1)
    # Further places that are told where one is asked for.
    alternatives: int = Field(default=5, ge=0)
    # How sure a stop beside others must be: a plan with a gap serves nobody, so the likeliest is told; ...
    least_sure_in_plan: float = Field(default=0.25, ge=0, le=1)
    # ... and where it is not said that there are several: a guess below it is as often wrong as right.
    least_sure_apart: float = Field(default=0.4, ge=0, le=1)
    # Standard deviations by which two distances must differ to be told apart.
    decided_sigmas: float = Field(default=2.0, ge=0)
    # Times as sure as before, where they do not.
    undecided_share: float = Field(default=0.7, ge=0, le=1)
    # Times the usual gap between a place and its nearest neighbour that "next to" reaches, ...
    neighbour_gaps: float = Field(default=4.0, gt=0)
    # ... and metres that it reaches at least, in maps of few, close signs.
    neighbour_reach: float = Field(default=6.0, gt=0)
    # Share of the way to what is opposite that runs along the sign's normal: within 45 degrees of it.
    across_share: float = Field(default=0.7, gt=0, le=1)
    # Share of the way to what is left or right that runs sideways: boards of one wall stand out of it unevenly.
    beside_share: float = Field(default=0.35, gt=0, le=1)
    # Times a metre straight on that one aside counts: what is straight opposite, or straight beside, is meant first.
    aside_cost: float = Field(default=2.0, ge=1)
    # Cosine from which facings are opposed, turned round: boards that face one another across a corridor.
    opposed: float = Field(default=0.3, ge=0, le=1)
    # Times as far that what faces the anchor counts as its neighbour: it is opposite.
    opposed_cost: float = Field(default=2.0, ge=1)
    # Cosine between facings from which a board opposite looks away, and metres for which that counts.
    turned_away: float = Field(default=0.5, ge=0, le=1)
    turned_away_cost: float = Field(default=10.0, ge=0)
    # Times the straight way within which a place lies between two others.
    detour: float = Field(default=1.5, ge=1)
    # Share of the way between two places by which it is longer past what stands between them, not across from there.
    pair_detour: float = Field(default=0.05, ge=0)
    # Places that each of two anchors may be, where it is not sure which is meant.
    pair_likely: int = Field(default=2, ge=1)
    # Metres of height between neighbouring signs of two floors: signs of one hang closer together.
    floor_height: float = Field(default=2.0, gt=0)
    # Boards with room numbers that must agree on what a floor is called.
    floor_witnesses: int = Field(default=2, ge=1)
