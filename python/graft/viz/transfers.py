"""What every picture asks of transfers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from graft.errors import InputError
from graft.viz.colors import Colors, matched_colors, part_colors

if TYPE_CHECKING:
    from graft.contact.transfer import TransferredContact


def as_sequence(transfers: TransferredContact | Sequence[TransferredContact]) -> list[TransferredContact]:
    """Return one or several transfers as a list.

    Raises:
        InputError: There is none.
    """
    several = list(transfers) if isinstance(transfers, Sequence) else [transfers]
    if not several:
        raise InputError("transfers: expected at least one, got none")
    return several


def colors_of(transfer: TransferredContact) -> tuple[Colors, Colors]:
    """Return the colours of the source's and of the target's parts."""
    source = part_colors(len(transfer.match.source.object.parts), transfer.source_part)
    return source, matched_colors(transfer.match.transport.plan, source)


def in_mask(transfer: TransferredContact) -> bool | None:
    """Return whether the contact lies on a graspable part of the target; None when nobody said which are."""
    graspable = transfer.match.target.object.graspable
    return transfer.target_part in graspable if graspable else None
