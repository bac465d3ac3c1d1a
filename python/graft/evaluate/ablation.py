"""What every piece of graft is worth: the same evaluation with one piece taken out or changed.

Every variation is a set of public parameters; nothing is patched.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from graft.evaluate.methods import Graft, Graphs
from graft.features import FAMILIES, GeometricDescriptor
from graft.graph import PartGraph, source_mass
from graft.transport import UFGW, Transport

ALPHAS = (0.1, 0.3, 0.7, 0.9)
"""Weights of the features that are swept beside the default and the two ends."""

EPSILONS = (0.005, 0.02, 0.1, 0.3)
"""Entropies that are swept beside the default."""


@dataclass(frozen=True)
class RootAnchored:
    """UFGW whose target masses fall off from one part instead of being found by EM.

    The root is the target part with the least feature cost to the demonstrated one, taken greedily; the
    masses are those a source would have whose contact were on the root, saliency^hops V.

    Attributes:
        solver: Parameters of the matching; its `em_rate` is not used.
    """

    solver: UFGW = field(default_factory=UFGW)

    def batch(self, sources: Sequence[PartGraph], source_parts: Sequence[int], target: PartGraph) -> list[Transport]:
        """Match many sources against one target, in order."""
        solver = replace(self.solver, em_rate=None)
        features = solver.features(sources, target)
        roots = [int(np.argmin(cost[part])) for cost, part in zip(features, source_parts, strict=True)]
        masses = [source_mass(target, root, solver.saliency) for root in roots]
        return solver.solve(sources, source_parts, target, masses)


PAPER = UFGW(lambda_relation=0.0, part_weight=0.0, doubt_weight=0.0, rival_weight=0.0)
"""Boxes and descriptors alone, matches ranked by the transport's cost alone."""


def ablations() -> list[Graft]:
    """Return graft as it is, first, and every variation of it."""
    single = [
        Graft(f"descriptor: {family} only", graphs=Graphs(GeometricDescriptor(families=(family,))))
        for family in FAMILIES
    ]
    return [
        Graft(),
        Graft("without graph (alpha 1)", UFGW(alpha=1.0)),
        Graft("without descriptor", graphs=Graphs(descriptor=None)),
        Graft("without boxes (lambda_obb 0)", UFGW(lambda_obb=0.0)),
        Graft("without relations (lambda_relation 0)", UFGW(lambda_relation=0.0)),
        Graft("without the part's cost in the ranking", UFGW(part_weight=0.0)),
        Graft("without doubt in the ranking", UFGW(doubt_weight=0.0)),
        Graft("without rivals in the ranking", UFGW(rival_weight=0.0)),
        Graft("without votes", voters=1),
        Graft("five voters", voters=5),
        Graft("ranked as in the paper", UFGW(part_weight=0.0, doubt_weight=0.0, rival_weight=0.0), voters=1),
        Graft("cost and ranking as in the paper", PAPER, voters=1),
        Graft("without features (alpha 0)", UFGW(alpha=0.0)),
        Graft("without saliency (gamma 1)", UFGW(saliency=1.0)),
        Graft("without EM", UFGW(em_rate=None)),
        Graft("root anchor instead of EM", RootAnchored()),
        Graft("structure: shortest path", graphs=Graphs(structure="shortest_path")),
        Graft("loss: absolute", UFGW(loss="absolute")),
        Graft("entropy: plain", UFGW(entropy="plain")),
        Graft("entropy: unit", UFGW(entropy="unit")),
        Graft("cost: objective", UFGW(cost="objective")),
        Graft("cost: paper", UFGW(cost="paper")),
        Graft("cost: debiased", UFGW(cost="debiased")),
        Graft("features as the paper writes them", UFGW(variant="paper")),
        *single,
        *[Graft(f"alpha {alpha:g}", UFGW(alpha=alpha)) for alpha in ALPHAS],
        *[Graft(f"eps {eps:g}", UFGW(eps=eps)) for eps in EPSILONS],
        Graft("landing: frames, no codes", landing="projected"),
        Graft("landing: boxes not aligned", landing="unaligned"),
    ]
