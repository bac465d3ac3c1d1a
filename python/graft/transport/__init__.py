"""Unbalanced fused Gromov-Wasserstein transport (UFGW) with EM on the target masses.

`ufgw` and `ufgw_batch` take plain matrices, `ufgw_packed` takes many pairs end to end; `UFGW` takes part graphs.
"""

from graft.transport.gradients import Gradients, ufgw_gradients
from graft.transport.graphs import UFGW, claim, matched_part, part_shares
from graft.transport.packed import PackedGraphs, Ranked
from graft.transport.pairs import Pairs
from graft.transport.result import TERMS, Transport, Transports
from graft.transport.solver import ufgw, ufgw_batch, ufgw_packed

__all__ = [
    "TERMS",
    "UFGW",
    "Gradients",
    "PackedGraphs",
    "Pairs",
    "Ranked",
    "Transport",
    "Transports",
    "claim",
    "matched_part",
    "part_shares",
    "ufgw",
    "ufgw_batch",
    "ufgw_gradients",
    "ufgw_packed",
]
