"""Measure transferred contacts: metrics, protocols, baselines, ablations, diversity."""
