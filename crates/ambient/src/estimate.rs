//! A value with its standard error.

/// An estimate from samples: the value and its standard error, 0 where the value is exact.
///
/// `T` is the value's type. The standard error of a colour is that of the mean of its channels.
///
/// ```
/// let open = ambake_ambient::Estimate { value: 0.75_f64, std_err: 0.01 };
/// assert!((open.value - 0.74).abs() < 2.0 * open.std_err);
/// ```
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Estimate<T = f64> {
    /// The value.
    pub value: T,
    /// Its standard error, in the value's unit.
    pub std_err: f64,
}

impl<T> Estimate<T> {
    /// A value that is known without error.
    pub const fn exact(value: T) -> Self {
        Self {
            value,
            std_err: 0.0,
        }
    }
}
