//! Locks between processes.

use std::fs::{File, TryLockError};
use std::io;

/// A lock on an open file or directory. The system frees it where the process dies.
///
/// It is given up by name when dropped. To close the file is not enough: a child process that another thread is just
/// starting holds a copy of every open file until it runs its own program, and the lock with it.
#[derive(Debug)]
pub(crate) struct Lock(File);

impl Lock {
    /// The lock on `file`, or `None` where another holds it. A file system without locks is used without.
    pub fn of(file: &File) -> io::Result<Option<Self>> {
        let lock = Self(file.try_clone()?);
        match lock.0.try_lock() {
            Err(TryLockError::WouldBlock) => Ok(None),
            _ => Ok(Some(lock)),
        }
    }

    /// The lock on `file` where it is certain that nobody else holds it: `None` also on a file system without locks.
    pub fn proved(file: &File) -> Option<Self> {
        let lock = Self(file.try_clone().ok()?);
        lock.0.try_lock().is_ok().then_some(lock)
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        // Without a lock there is none to give up.
        let _ = self.0.unlock();
    }
}
