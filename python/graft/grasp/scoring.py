"""What a planned grasp's score is made of."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from graft.errors import InputError


@dataclass(frozen=True)
class ScoreWeights:
    """Weights of a score's terms; the score is their weighted geometric mean, in [0, 1].

    A term is in [0, 1]. What does not apply (no contact, no demonstrated approach, no support) is 1 for all.

    Attributes:
        cone: How far inside the friction cone the line between the pads stays, seen from normals and pads.
        distance: Gaussian of the distance from the contact to the nearest place between the pads.
        lever: Distance of the centre of mass from the pads, horizontal where up is known; 5 cm halve it.
        approach: Agreement with the contact's demonstrated approach.
        above: Coming from above, where there is a support.
        width: What is left of the stroke.
        pads: Share of the worse pad's rectangle that touches; half of it is enough.
        part: Both pads press on the part that was asked for.
    """

    cone: float = 2.0
    distance: float = 2.0
    lever: float = 4.0
    approach: float = 1.0
    above: float = 1.0
    width: float = 0.5
    pads: float = 2.0
    part: float = 1.0

    def __post_init__(self) -> None:
        values = self.values()
        for field, value in zip(fields(self), values, strict=True):
            if not (np.isfinite(value) and value >= 0):
                raise InputError(f"weight {field.name}: expected a number of at least 0, got {value}")
        if not any(values):
            raise InputError("weights: expected at least one above 0, got none")

    def values(self) -> tuple[float, ...]:
        """Return the weights in the order of the fields."""
        return tuple(getattr(self, field.name) for field in fields(self))
