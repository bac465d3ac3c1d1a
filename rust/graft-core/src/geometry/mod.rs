//! Boxes, hulls, sampling, rays: everything about one mesh or point set.
