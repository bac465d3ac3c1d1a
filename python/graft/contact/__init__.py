"""Carry a demonstrated contact over to a target: part match, canonical frames, Fourier codes, landing."""

from graft.contact.agreement import VOTERS, agree
from graft.contact.canonical import CanonicalFrame
from graft.contact.dense import DenseMap, dense_map
from graft.contact.encoding import fourier_encoding
from graft.contact.frames import FramePair, align_parts
from graft.contact.transfer import TransferredContact, transfer_contact

__all__ = [
    "VOTERS",
    "CanonicalFrame",
    "DenseMap",
    "FramePair",
    "TransferredContact",
    "agree",
    "align_parts",
    "dense_map",
    "fourier_encoding",
    "transfer_contact",
]
