//! Relations between parts: edge lengths, adjacency, saliency, masses.
