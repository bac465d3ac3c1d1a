"""Let the contacts of several matches vote: the part that most of them land on comes first.

The best match alone may be a body that resembles the target's body; the next four may all say handle. Every match
votes for the part it lands on, the better its cost the louder.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from graft.contact.transfer import TransferredContact, confidence_in
from graft.errors import InputError

VOTERS = 10
"""How many matches vote. Over the development objects ten or fifteen are better than five, most of all where parts are
perturbed: a wrong best match among five needs only two that agree with it."""

VOTE_SCALE = 0.1
"""A match whose cost is higher than the best one's by this speaks 1/e as loud. Over the development objects votes at
0.03 to 0.1 are never worse than the best match alone; the more so, the larger the library."""


def agree(transfers: Sequence[TransferredContact]) -> list[TransferredContact]:
    """Return the transfers in the order of their parts' votes, those of one part in the order given.

    Args:
        transfers: Contacts of several matches on one target, the best match first; `VOTERS` are a good number.

    Returns:
        The same contacts; their confidence is that in the share of the votes that their part has
        (`graft.contact.transfer.confidence_in`). Ties go to the part with the lowest index.

    Raises:
        InputError: The transfers are on different targets.
    """
    if not transfers:
        return []
    targets = {id(t.match.target) for t in transfers}
    if len(targets) > 1:
        raise InputError(f"transfers: expected contacts on one target, got {len(targets)}")
    costs = np.array([t.match.cost for t in transfers])
    loudness = np.exp(-(costs - costs.min()) / VOTE_SCALE)
    votes = np.bincount([t.target_part for t in transfers], loudness) / loudness.sum()
    order = sorted(range(len(transfers)), key=lambda k: (-votes[transfers[k].target_part], transfers[k].target_part, k))
    return [
        replace(t, confidence=confidence_in(float(votes[t.target_part]), t.match.cost))
        for t in (transfers[k] for k in order)
    ]
