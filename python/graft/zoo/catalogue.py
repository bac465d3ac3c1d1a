"""The zoo's list of categories, and objects by category and seed."""

from __future__ import annotations

import difflib
import zlib
from collections.abc import Callable

import numpy as np
from numpy.random import Generator

from graft.errors import InputError
from graft.objects import Demonstration, PartObject
from graft.zoo import bags, bottles, gadgets, open_vessels, pots, tools
from graft.zoo.design import Design

DEMONSTRATED: dict[str, Callable[[Generator], Design]] = {
    "water_bucket": open_vessels.water_bucket,
    "teapot": pots.teapot,
    "wine_bottle": bottles.wine_bottle,
    "mug": open_vessels.mug,
}
"""The paper's four demonstrated categories."""

UNSEEN: dict[str, Callable[[Generator], Design]] = {
    "detergent": bottles.detergent,
    "shampoo": bottles.shampoo,
    "spray": bottles.spray,
    "kettle": pots.kettle,
    "briefcase": bags.briefcase,
    "handbag": bags.handbag,
    "phone": gadgets.phone,
    "remote": gadgets.remote,
}
"""The paper's eight categories that nobody demonstrated."""

MORE: dict[str, Callable[[Generator], Design]] = {
    "pan": open_vessels.pan,
    "jug": open_vessels.jug,
    "watering_can": pots.watering_can,
    "hammer": tools.hammer,
    "screwdriver": tools.screwdriver,
    "knife": tools.knife,
    "scissors": tools.scissors,
    "headphones": gadgets.headphones,
    "basket": open_vessels.basket,
    "flashlight": tools.flashlight,
}
"""Ten categories that the paper does not have."""

DESIGNS = DEMONSTRATED | UNSEEN | MORE


def categories() -> tuple[str, ...]:
    """Return every category's name: the demonstrated, the unseen and the others, in this order."""
    return tuple(DESIGNS)


def demonstrated() -> tuple[str, ...]:
    """Return the paper's four demonstrated categories."""
    return tuple(DEMONSTRATED)


def unseen() -> tuple[str, ...]:
    """Return the paper's eight unseen categories."""
    return tuple(UNSEEN)


def more() -> tuple[str, ...]:
    """Return the categories that are neither demonstrated nor unseen in the paper."""
    return tuple(MORE)


def make(category: str, seed: int = 0) -> PartObject:
    """Return a variant of a household object, the same for the same category and seed everywhere.

    Metres, lowest point at z = 0. Standing objects have `up` = (0, 0, 1); those that lie have None.

    Args:
        category: One of `categories()`.
        seed: Not negative; chooses the variant.

    Raises:
        InputError: No such category, or the seed is not a whole number from 0 on.
    """
    return _design(category, seed).object(f"{category}_{seed}", category)


def demonstration(category: str, seed: int = 0) -> Demonstration:
    """Return the same variant as `make` with the place where a person takes it.

    The contact lies in the middle of a face; its metadata's `task` says what the object is taken for.

    Args:
        category: One of `categories()`.
        seed: Not negative; chooses the variant.

    Raises:
        InputError: No such category, or the seed is not a whole number from 0 on.
    """
    return _design(category, seed).demonstration(f"{category}_{seed}", category)


def _design(category: str, seed: int) -> Design:
    if category not in DESIGNS:
        near = difflib.get_close_matches(str(category).lower().replace(" ", "_"), DESIGNS, n=1)
        hint = f"; did you mean {near[0]!r}?" if near else ""
        raise InputError(f"category: expected one of {', '.join(DESIGNS)}, got {category!r}{hint}")
    if isinstance(seed, bool) or not isinstance(seed, int | np.integer) or seed < 0:
        raise InputError(f"seed: expected a whole number from 0 on, got {seed!r}")
    # crc32 is the same in every process and version; hash() is not.
    return DESIGNS[category](np.random.default_rng([zlib.crc32(category.encode()), int(seed)]))
