"""The compiled core. Arrays are C-contiguous; every function raises ValueError naming a bad argument."""

__version__: str
