//! How far the charts of all meshes are, told in triangles.

use layers::Progress;
use std::sync::atomic::{AtomicU64, Ordering};

/// What is told of all meshes together.
pub(crate) struct Told<'a> {
    progress: &'a dyn Progress,
    total: u64,
    done: AtomicU64,
}

/// What is told of one mesh. Each of its triangles counts once, whatever is done to it.
pub(crate) struct OfMesh<'a> {
    all: &'a Told<'a>,
    left: AtomicU64,
}

impl<'a> Told<'a> {
    pub fn new(progress: &'a dyn Progress, triangles: usize) -> Self {
        Self {
            progress,
            total: triangles as u64,
            done: AtomicU64::new(0),
        }
    }

    /// A mesh of so many of the triangles.
    pub fn mesh(&'a self, triangles: usize) -> OfMesh<'a> {
        OfMesh {
            all: self,
            left: AtomicU64::new(triangles as u64),
        }
    }
}

impl OfMesh<'_> {
    /// So many more of its triangles lie in charts.
    pub fn done(&self, triangles: usize) {
        let less = |left: u64| Some(left.saturating_sub(triangles as u64));
        let left = self
            .left
            .fetch_update(Ordering::Relaxed, Ordering::Relaxed, less);
        let new = left.map_or(0, |left| left.min(triangles as u64));
        if new > 0 {
            let done = self.all.done.fetch_add(new, Ordering::Relaxed) + new;
            self.all.progress.advance(done, self.all.total);
        }
    }

    /// All of its triangles lie in charts.
    pub fn finish(&self) {
        self.done(usize::MAX);
    }

    pub fn cancelled(&self) -> bool {
        self.all.progress.cancelled()
    }
}
