//! What stands in the way: an object's triangles and the plane it stands on.

use crate::Error;
use crate::geometry::{OrientedBox, Vec3, points_of};

/// An object and its support.
#[derive(Debug)]
pub struct Obstacles {
    triangles: Vec<[Vec3; 3]>,
    support: Option<(Vec3, f64)>,
}

impl Obstacles {
    /// Take an object's triangles; nothing may come to where normal . p < offset of the support.
    ///
    /// # Errors
    /// A face names a vertex that is not there.
    pub fn new(vertices: &[f64], faces: &[i64], support: Option<(Vec3, f64)>) -> Result<Self, Error> {
        let points = points_of(vertices);
        let corner = |&i: &i64| {
            let found = usize::try_from(i).ok().and_then(|i| points.get(i)).copied();
            found.ok_or_else(|| Error::value("faces", format!("indices of {} vertices", points.len()), i))
        };
        let (rows, _) = faces.as_chunks::<3>();
        let triangles = rows.iter().map(|[a, b, c]| Ok([corner(a)?, corner(b)?, corner(c)?]));
        Ok(Self { triangles: triangles.collect::<Result<_, Error>>()?, support })
    }

    /// Whether a box touches the object or reaches below the support.
    #[must_use]
    pub fn touches(&self, b: &OrientedBox) -> bool {
        let below = self.support.is_some_and(|(normal, offset)| {
            let reach: f64 = (0..3).map(|k| b.half_extents[k] * b.axes[k].dot(&normal).abs()).sum();
            b.center.dot(&normal) - offset < reach
        });
        below || self.triangles.iter().any(|t| overlaps(b, t))
    }
}

fn overlaps(b: &OrientedBox, t: &[Vec3; 3]) -> bool {
    let l = t.map(|p| Vec3::from_fn(|k, _| (p - b.center).dot(&b.axes[k])));
    let splits = |axis: Vec3| {
        let s = l.map(|p| p.dot(&axis));
        let r: f64 = (0..3).map(|k| b.half_extents[k] * axis[k].abs()).sum();
        s[0].min(s[1]).min(s[2]) > r || s[0].max(s[1]).max(s[2]) < -r
    };
    let e = [l[1] - l[0], l[2] - l[1], l[0] - l[2]];
    let units = [Vec3::x(), Vec3::y(), Vec3::z()];
    !(units.iter().any(|u| splits(*u))
        || splits(e[0].cross(&e[1]))
        || units.iter().any(|u| e.iter().any(|e| splits(u.cross(e)))))
}
