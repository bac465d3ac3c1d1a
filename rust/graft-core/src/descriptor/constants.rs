//! Mean and standard deviation of every raw feature over real parts.
//!
//! Measured with `raw_features` (1024 samples, seeds 0 to 3) on the 96 parts of 19 meshes of the
//! Princeton segmentation benchmark (amphorae, pots, ewers, glasses, kylikes, mugs, pliers, a bottle, a goblet) and 9 YCB
//! scans (bottles, cutlery, tools): every other object of each set in the order of their names.

/// (mean, deviation) of the hull features.
#[rustfmt::skip]
#[allow(clippy::approx_constant)]
pub const HULL: [[f64; 2]; super::moments::HULL] = [
    [-0.8643, 0.6415], [-0.5783, 0.4842], [-1.0305, 0.5290], [0.5449, 0.1115], [0.1445, 0.0790], [0.0459, 0.0335],
    [0.1379, 0.0911], [-0.1483, 0.0548], [0.8026, 0.1636], [-0.2534, 0.2964],
];

/// (mean, deviation) of the inertia features.
#[rustfmt::skip]
#[allow(clippy::approx_constant)]
pub const INERTIA: [[f64; 2]; super::moments::INERTIA] = [
    [-0.8490, 0.6698], [-0.5384, 0.5623], [0.1115, 0.0937], [1.4784, 0.2782], [0.9333, 0.0364], [1.8762, 0.2178],
    [0.1165, 0.1292],
];

/// (mean, deviation) of the curve features.
#[rustfmt::skip]
#[allow(clippy::approx_constant)]
pub const CURVE: [[f64; 2]; super::curve::CURVE] = [
    [-1.9882, 0.4511], [0.2604, 0.0722], [0.2240, 0.0990], [0.6352, 0.1750], [0.0351, 0.0770], [0.3575, 0.1119],
    [0.6049, 0.1298], [-0.3165, 0.2027],
];

/// (mean, deviation) of the distributions features.
#[rustfmt::skip]
#[allow(clippy::approx_constant)]
pub const DISTRIBUTIONS: [[f64; 2]; super::distributions::DISTRIBUTIONS] = [
    [0.4387, 0.1764], [0.5819, 0.1561], [0.7186, 0.1225], [0.8559, 0.0818], [0.9934, 0.0473], [1.1334, 0.0455],
    [1.2780, 0.0828], [1.4635, 0.1426], [0.3758, 0.0986], [0.6445, 0.1519], [0.8574, 0.1636], [1.0708, 0.1457],
    [1.2993, 0.1076], [1.5573, 0.0562], [1.8690, 0.0714], [2.3334, 0.1902], [0.2549, 0.0673], [0.3805, 0.0987],
    [0.4661, 0.1182], [0.5408, 0.1324], [0.6138, 0.1434], [0.6920, 0.1517], [0.7861, 0.1580], [0.9330, 0.1633],
    [0.1639, 0.0710], [0.3340, 0.1309], [0.4924, 0.1693], [0.6804, 0.1865], [0.9457, 0.1586], [1.4101, 0.1669],
    [1.8882, 0.3151], [2.4076, 0.2827],
];

/// (mean, deviation) of the harmonics features.
#[rustfmt::skip]
#[allow(clippy::approx_constant)]
pub const HARMONICS: [[f64; 2]; super::harmonics::HARMONICS] = [
    [0.1238, 0.0920], [0.0454, 0.0602], [0.0662, 0.0893], [0.0521, 0.0732], [0.0606, 0.0737], [0.0506, 0.0669],
    [0.0489, 0.0628], [0.2600, 0.0464], [0.0676, 0.0577], [0.2468, 0.1138], [0.0932, 0.0691], [0.1479, 0.1404],
    [0.0981, 0.0851], [0.1519, 0.1244], [0.3489, 0.1359], [0.0539, 0.0411], [0.3768, 0.1333], [0.0715, 0.0591],
    [0.3470, 0.1378], [0.0918, 0.0554], [0.2491, 0.1850], [0.2139, 0.0352], [0.0503, 0.0330], [0.3403, 0.1188],
    [0.1077, 0.0760], [0.3305, 0.1656], [0.1420, 0.0957], [0.2995, 0.1764], [0.0534, 0.0418], [0.0391, 0.0397],
    [0.1104, 0.0927], [0.0694, 0.0620], [0.1310, 0.1186], [0.0912, 0.0815], [0.1398, 0.1294],
];
