"""The evaluations of `graft evaluate`: one file each, and what they share."""
