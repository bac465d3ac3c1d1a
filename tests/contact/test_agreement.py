from dataclasses import replace

import numpy as np
import pytest

from graft import zoo
from graft.contact import agree, transfer_contact
from graft.contact.agreement import VOTE_SCALE
from graft.contact.transfer import COST_SCALE, confidence_in
from graft.errors import InputError
from graft.library import Library


@pytest.fixture(scope="module")
def transfers():
    library = Library()
    library.extend(zoo.demonstration(category) for category in zoo.demonstrated())
    return [transfer_contact(match) for match in library.retrieve(zoo.make("kettle", 1), k=4)]


def voting(transfer, part, cost):
    """The transfer as if its match had cost `cost` and landed on `part`."""
    return replace(transfer, match=replace(transfer.match, cost=cost), target_part=part)


def test_two_good_matches_outvote_the_best(transfers):
    given = [
        voting(transfers[0], 0, 0.30),
        voting(transfers[1], 1, 0.30 + 0.1 * VOTE_SCALE),
        voting(transfers[2], 1, 0.30 + 0.2 * VOTE_SCALE),
    ]
    ranked = agree(given)
    assert [t.target_part for t in ranked] == [1, 1, 0]
    assert ranked[0].match is given[1].match, "within a part the order stays"
    loud = np.exp([0.0, -0.1, -0.2])
    assert ranked[0].confidence == pytest.approx(
        loud[1:].sum() / loud.sum() * np.exp(-np.square(given[1].match.cost / COST_SCALE))
    )


def test_poor_matches_do_not_outvote_the_best(transfers):
    given = [voting(transfers[0], 0, 0.3)] + [voting(t, 1, 0.3 + 5 * VOTE_SCALE) for t in transfers[1:]]
    assert agree(given)[0].match is given[0].match


def test_equal_votes_go_to_the_lowest_part_and_one_or_none_stay(transfers):
    given = [voting(transfers[0], 2, 0.3), voting(transfers[1], 1, 0.3)]
    assert [t.target_part for t in agree(given)] == [1, 2]
    assert agree([]) == []
    assert agree(transfers[:1])[0].contact is transfers[0].contact


def test_contacts_on_different_targets_cannot_vote(transfers):
    library = Library()
    library.add(zoo.demonstration("mug"))
    other = transfer_contact(library.retrieve(zoo.make("jug"))[0])
    with pytest.raises(InputError, match="expected contacts on one target, got 2"):
        agree([transfers[0], other])


def test_confidence_rises_with_votes_falls_with_cost_and_stays_in_the_unit_interval():
    costs = np.linspace(-0.5, 5.0, 12)
    table = np.array([[confidence_in(share, cost) for share in np.linspace(0, 1, 6)] for cost in costs])
    assert ((table >= 0) & (table <= 1)).all()
    assert (np.diff(table, axis=1) > 0).all()
    assert (np.diff(table, axis=0) <= 0).all()
    assert confidence_in(1.0, 0.0) == 1.0
    assert confidence_in(1.0, 3.0) < 0.05, "nothing fits"
