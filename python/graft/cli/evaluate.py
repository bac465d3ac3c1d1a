"""`graft evaluate ...`: measure contacts, what becomes of them in physics, and the data made of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import tyro

from graft.cli.evaluation.contacts import Ablation, Affordance, Varied
from graft.cli.evaluation.generation import Generation
from graft.cli.evaluation.segmentation import Segmentation
from graft.cli.evaluation.simulation import Simulation


@dataclass(frozen=True)
class Evaluate:
    """Measure transferred contacts: where they land, what a gripper can do there, and what it teaches."""

    evaluation: tyro.conf.OmitSubcommandPrefixes[
        Annotated[Affordance, tyro.conf.subcommand("affordance")]
        | Annotated[Ablation, tyro.conf.subcommand("ablation")]
        | Annotated[Varied, tyro.conf.subcommand("diversity")]
        | Annotated[Segmentation, tyro.conf.subcommand("segmentation")]
        | Annotated[Simulation, tyro.conf.subcommand("simulation")]
        | Annotated[Generation, tyro.conf.subcommand("generation")]
    ]

    def run(self) -> int:
        """Run what was chosen; returns the exit code."""
        return self.evaluation.run()
