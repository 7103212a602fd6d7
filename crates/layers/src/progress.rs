//! How a long job tells how far it is, and is told to stop.

/// A listener of a long job: a bake, a picture, a capture. It is called from any thread, often; it should be quick.
///
/// `()` listens to nothing and never cancels.
///
/// ```
/// use ambake_layers::Progress;
/// struct Percent;
/// impl Progress for Percent {
///     fn advance(&self, done: u64, total: u64) {
///         println!("{} %", 100 * done / total.max(1));
///     }
/// }
/// Percent.advance(1, 4);
/// assert!(!Percent.cancelled());
/// ```
pub trait Progress: Sync {
    /// `done` of `total` units of work are finished: texels of a bake, pixels of a picture, triangles that lie in
    /// charts.
    fn advance(&self, done: u64, total: u64);

    /// What is done from now on, such as `making charts` or `gather 2`. What [`Self::advance`] tells then is of that
    /// alone.
    fn phase(&self, name: &str) {
        let _ = name;
    }

    /// So many rays were cast since the last call.
    fn rays(&self, cast: u64) {
        let _ = cast;
    }

    /// Something that the user should know now, in one line.
    fn note(&self, line: &str) {
        let _ = line;
    }

    /// True to stop the job at the next place where it can stop.
    fn cancelled(&self) -> bool {
        false
    }
}

impl Progress for () {
    fn advance(&self, _done: u64, _total: u64) {}
}
