"""Unbalanced fused Gromov-Wasserstein transport (UFGW) with EM on the target masses.

`ufgw` and `ufgw_batch` take plain matrices; `UFGW` takes part graphs.
"""

from graft.transport.graphs import UFGW, claim, matched_part, part_shares
from graft.transport.solver import TERMS, Transport, ufgw, ufgw_batch

__all__ = ["TERMS", "UFGW", "Transport", "claim", "matched_part", "part_shares", "ufgw", "ufgw_batch"]
