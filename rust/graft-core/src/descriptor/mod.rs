//! Rotation-invariant geometric descriptors of parts.
//!
//! A part is brought to its own frame ([`surface`]), five families of numbers that do not depend on pose, scale or
//! mirroring are taken from it, and [`standard`] makes them commensurate and comparable by cosine.

mod constants;
mod curve;
mod distributions;
mod graph;
mod harmonics;
mod hull;
mod moments;
mod standard;
mod surface;

use crate::Error;
use rayon::prelude::*;
use surface::Surface;

/// Kinds of features, in the order of their columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Family {
    /// Proportions of the convex hull and how the surface lies in it.
    Hull,
    /// Moments of the surface.
    Inertia,
    /// Length, thickness and bend of the part as a tube.
    Curve,
    /// Shape distributions D1, D2, D3 and A3.
    Distributions,
    /// Spherical harmonics on shells.
    Harmonics,
}

impl Family {
    /// All families, in the order of their columns.
    pub const ALL: [Self; 5] = [Self::Hull, Self::Inertia, Self::Curve, Self::Distributions, Self::Harmonics];

    /// The name used across the border.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Hull => "hull",
            Self::Inertia => "inertia",
            Self::Curve => "curve",
            Self::Distributions => "distributions",
            Self::Harmonics => "harmonics",
        }
    }

    /// The family of that name.
    ///
    /// # Errors
    /// No family has it.
    pub fn named(name: &str) -> Result<Self, Error> {
        Self::ALL.into_iter().find(|family| family.name() == name).ok_or_else(|| {
            let names = Self::ALL.map(Self::name).join(", ");
            Error::value("families", format!("some of {names}"), format!("{name:?}"))
        })
    }

    /// Number of raw features.
    #[must_use]
    pub fn n_features(self) -> usize {
        match self {
            Self::Hull => moments::HULL,
            Self::Inertia => moments::INERTIA,
            Self::Curve => curve::CURVE,
            Self::Distributions => distributions::DISTRIBUTIONS,
            Self::Harmonics => harmonics::HARMONICS,
        }
    }

    fn features(self, surface: &Surface, seed: u64) -> Vec<f64> {
        match self {
            Self::Hull => moments::hull(surface),
            Self::Inertia => moments::inertia(surface),
            Self::Curve => curve::curve(surface),
            Self::Distributions => distributions::distributions(surface, seed),
            Self::Harmonics => harmonics::harmonics(surface),
        }
    }
}

/// What is computed and how finely.
#[derive(Debug, Clone)]
pub struct Options {
    /// Families, each once.
    pub families: Vec<Family>,
    /// Points sampled on each part.
    pub samples: usize,
    /// Seed of the sampling; the same for every part, so that a part's row does not depend on its neighbours.
    pub seed: u64,
}

/// Fewest samples from which slabs and quantiles can be told.
pub const MIN_SAMPLES: usize = 64;
/// Most samples: more would cost seconds and change nothing.
pub const MAX_SAMPLES: usize = 65_536;

impl Options {
    /// Width of a descriptor.
    #[must_use]
    pub fn dim(&self) -> usize {
        self.families.iter().map(|&family| standard::WIDTH * family.n_features()).sum()
    }

    fn check(&self) -> Result<(), Error> {
        if self.families.is_empty() {
            return Err(Error::value("families", "at least one", "none"));
        }
        for (i, family) in self.families.iter().enumerate() {
            if self.families[..i].contains(family) {
                return Err(Error::value("families", "each family once", format!("{} twice", family.name())));
            }
        }
        if !(MIN_SAMPLES..=MAX_SAMPLES).contains(&self.samples) {
            return Err(Error::value("samples", format!("{MIN_SAMPLES} to {MAX_SAMPLES}"), self.samples));
        }
        Ok(())
    }
}

/// Parts packed one after the other; faces index the vertices of their own part.
#[derive(Debug, Clone, Copy)]
pub struct Parts<'a> {
    /// Positions of all parts.
    pub vertices: &'a [[f64; 3]],
    /// Triangles of all parts.
    pub faces: &'a [[i64; 3]],
    /// Part i has vertices `vertex_offsets[i]..vertex_offsets[i + 1]`.
    pub vertex_offsets: &'a [i64],
    /// Part i has faces `face_offsets[i]..face_offsets[i + 1]`; none makes it a cloud.
    pub face_offsets: &'a [i64],
}

/// Vertices and faces of one part.
type Slices<'a> = (&'a [[f64; 3]], &'a [[i64; 3]]);

impl<'a> Parts<'a> {
    fn slices(&self) -> Result<Vec<Slices<'a>>, Error> {
        let vertices = ranges("vertex_offsets", self.vertex_offsets, self.vertices.len())?;
        let faces = ranges("face_offsets", self.face_offsets, self.faces.len())?;
        if vertices.len() != faces.len() {
            return Err(Error::shape("face_offsets", self.vertex_offsets.len(), self.face_offsets.len()));
        }
        let mut slices = Vec::with_capacity(vertices.len());
        for (i, (vertices, faces)) in vertices.into_iter().zip(faces).enumerate() {
            let (vertices, faces) = (&self.vertices[vertices], &self.faces[faces]);
            if vertices.is_empty() {
                return Err(Error::shape("vertex_offsets", "at least one vertex a part", format!("none in part {i}")));
            }
            if vertices.iter().flatten().any(|x| !x.is_finite()) {
                return Err(Error::value("vertices", "finite numbers", format!("others in part {i}")));
            }
            let n = vertices.len();
            if let Some(index) = faces.iter().flatten().find(|&&k| usize::try_from(k).map_or(true, |k| k >= n)) {
                return Err(Error::value("faces", format!("indices 0 to {} in part {i}", n - 1), index));
            }
            slices.push((vertices, faces));
        }
        Ok(slices)
    }
}

fn ranges(name: &'static str, offsets: &[i64], total: usize) -> Result<Vec<std::ops::Range<usize>>, Error> {
    let places: Option<Vec<usize>> = offsets.iter().map(|&offset| usize::try_from(offset).ok()).collect();
    match places {
        Some(places) if places.first() == Some(&0) && places.last() == Some(&total) && places.is_sorted() => {
            Ok(places.windows(2).map(|pair| pair[0]..pair[1]).collect())
        }
        _ => Err(Error::value(name, format!("ascending from 0 to {total}"), format!("{offsets:?}"))),
    }
}

/// Describe every part, one row of [`Options::dim`] each, of length 1: compare rows by cosine.
///
/// # Errors
/// Options or parts are out of range.
pub fn describe(parts: Parts<'_>, options: &Options) -> Result<Vec<f64>, Error> {
    rows(parts, options, |family, features, row| standard::embed(&options.families, family, features, row))
}

/// Features before they are made commensurate: what the constants of [`standard`] are measured on.
///
/// A part whose points coincide, and what a cloud cannot answer, is NaN.
///
/// # Errors
/// Options or parts are out of range.
pub fn raw_features(parts: Parts<'_>, options: &Options) -> Result<Vec<f64>, Error> {
    rows(parts, options, |_, features, row| row.extend_from_slice(features))
}

fn rows(
    parts: Parts<'_>,
    options: &Options,
    finish: impl Fn(Family, &[f64], &mut Vec<f64>) + Sync,
) -> Result<Vec<f64>, Error> {
    options.check()?;
    let slices = parts.slices()?;
    let rows: Vec<Vec<f64>> = slices
        .into_par_iter()
        .map(|(vertices, faces)| {
            let surface = Surface::new(vertices, faces, options.samples, options.seed);
            let mut row = Vec::new();
            for &family in &options.families {
                let features = match &surface {
                    Some(surface) => family.features(surface, options.seed),
                    None => vec![f64::NAN; family.n_features()],
                };
                finish(family, &features, &mut row);
            }
            row
        })
        .collect();
    Ok(rows.concat())
}
