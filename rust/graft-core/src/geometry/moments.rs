//! Moments of a surface, integrated exactly over its triangles: they do not depend on how it is cut into them.

use nalgebra::Matrix3;

use super::Vec3;

/// Skewness below this share of the deviation's cube does not choose a direction.
const SKEW_FLOOR: f64 = 1e-9;

/// Area, centroid and covariance of a surface.
#[derive(Debug, Clone, Copy)]
pub struct Moments {
    /// Area.
    pub area: f64,
    /// Centroid.
    pub centroid: Vec3,
    /// Covariance of the area about the centroid.
    pub covariance: Matrix3<f64>,
}

/// Integrate over triangles; `corner` turns what a face is made of into an index.
///
/// A surface without area has its vertices' mean and covariance.
#[must_use]
pub fn surface_moments<I: Copy>(vertices: &[Vec3], faces: &[[I; 3]], corner: impl Fn(I) -> usize) -> Moments {
    let origin = vertices[0];
    let (mut area, mut first, mut second) = (0.0, Vec3::zeros(), Matrix3::zeros());
    for face in faces {
        let [a, b, c] = face.map(|i| vertices[corner(i)] - origin);
        let share = (b - a).cross(&(c - a)).norm() / 2.0;
        let sum = a + b + c;
        area += share;
        first += sum * (share / 3.0);
        second += (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose()) * (share / 12.0);
    }
    let mut total = area;
    if area <= 0.0 {
        total = vertices.len() as f64;
        for v in vertices {
            let offset = v - origin;
            first += offset;
            second += offset * offset.transpose();
        }
    }
    let mean = first / total;
    Moments { area, centroid: origin + mean, covariance: second / total - mean * mean.transpose() }
}

/// The axes (columns, largest variance first) and variances of a covariance.
#[must_use]
pub fn principal(covariance: &Matrix3<f64>) -> (Matrix3<f64>, [f64; 3]) {
    let eigen = covariance.symmetric_eigen();
    let mut order = [0, 1, 2];
    order.sort_by(|&i, &j| eigen.eigenvalues[j].total_cmp(&eigen.eigenvalues[i]));
    let [x, y, _] = order.map(|i| eigen.eigenvectors.column(i).into_owned());
    // The eigenvectors of almost equal eigenvalues were found up to 1e-7 off right angles.
    let x = x.normalize();
    let y = (y - x * x.dot(&y)).normalize();
    (Matrix3::from_columns(&[x, y, x.cross(&y)]), order.map(|i| eigen.eigenvalues[i].max(0.0)))
}

/// Third moment of the surface along `axis` about `origin`, over its area.
#[must_use]
pub fn skewness<I: Copy>(
    vertices: &[Vec3],
    faces: &[[I; 3]],
    corner: impl Fn(I) -> usize,
    origin: &Vec3,
    axis: &Vec3,
) -> f64 {
    let (mut area, mut third) = (0.0, 0.0);
    for face in faces {
        let [a, b, c] = face.map(|i| vertices[corner(i)] - origin);
        let share = (b - a).cross(&(c - a)).norm();
        let [x, y, z] = [a, b, c].map(|p| p.dot(axis));
        // The mean of h^3 over a triangle is a tenth of the sum of all products of degree 3 of its corners' heights.
        let products = z * z * (z + x + y) + z * (x * x + x * y + y * y) + (x * x + y * y) * (x + y);
        third += share * products / 10.0;
        area += share;
    }
    if area > 0.0 { third / area } else { 0.0 }
}

/// Principal axes of a hull's surface as a rotation; the first two point to the side its skewness lies on.
#[must_use]
pub fn pose(vertices: &[Vec3], faces: &[[u32; 3]]) -> Matrix3<f64> {
    let moments = surface_moments(vertices, faces, |i| i as usize);
    let (axes, variances) = principal(&moments.covariance);
    let [x, y] = [0, 1].map(|k| {
        let axis = axes.column(k).into_owned();
        let skew = skewness(vertices, faces, |i| i as usize, &moments.centroid, &axis);
        if skew < -SKEW_FLOOR * variances[k].powf(1.5) { -axis } else { axis }
    });
    Matrix3::from_columns(&[x, y, x.cross(&y)])
}
