"""Rows of an evaluation of contacts: one method's answer to one query, with what the metrics say of it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Answer:
    """One predicted contact and what the metrics say of it.

    Attributes:
        source: Name of the demonstration it came from; None when there was none.
        source_category: Category of its object.
        part: Name of the target part.
        right: Whether that part is graspable.
        inside: Whether the point lies in the mask.
        nss: Normalised scanpath saliency of the point.
        distance: From the point to the mask, in shares of the diagonal.
        confidence: As the method says.
        point: (3,) in the posed target's frame and units.
    """

    source: str | None
    source_category: str | None
    part: str
    right: bool
    inside: bool
    nss: float
    distance: float
    confidence: float | None
    point: tuple[float, float, float]


@dataclass(frozen=True)
class Row:
    """One method's answer to one query.

    Attributes:
        method: Name of the method.
        query: Key of the query.
        target: Key of the target.
        category: The target's category.
        exchangeable: The answers are draws without a rank.
        answers: Best first.
    """

    method: str
    query: str
    target: str
    category: str
    exchangeable: bool
    answers: tuple[Answer, ...] = field(default=())

    @classmethod
    def read(cls, document: dict[str, Any]) -> Row:
        """Return the row that a line of the file tells."""
        answers = tuple(Answer(**{**a, "point": tuple(a["point"])}) for a in document["answers"])
        return cls(**{**document, "answers": answers})
