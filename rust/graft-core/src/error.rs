//! The one error type of the crate; the Python border maps it to `ValueError`.

/// What is wrong with an argument.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// An argument has the wrong shape or length.
    #[error("{name}: expected {expected}, got {got}")]
    Shape {
        /// The argument.
        name: &'static str,
        /// What it should be.
        expected: String,
        /// What it is.
        got: String,
    },
    /// A value is outside its range, or not finite.
    #[error("{name}: expected {expected}, got {got}")]
    Value {
        /// The argument.
        name: &'static str,
        /// What it should be.
        expected: String,
        /// What it is.
        got: String,
    },
}

// By value so that a caller writes `Error::shape("mu", 3, mu.len())`.
#[allow(clippy::needless_pass_by_value)]
impl Error {
    /// A wrong shape or length.
    pub fn shape(name: &'static str, expected: impl ToString, got: impl ToString) -> Self {
        Self::Shape { name, expected: expected.to_string(), got: got.to_string() }
    }

    /// A value outside its range.
    pub fn value(name: &'static str, expected: impl ToString, got: impl ToString) -> Self {
        Self::Value { name, expected: expected.to_string(), got: got.to_string() }
    }
}
