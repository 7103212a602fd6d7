//! The end of a program that the system gives no more memory: one line and status 1, where Rust would abort with a
//! trace.
//!
//! The allocator is the system's; only what it refuses is looked at. All that was saved stays as it would after a
//! kill. Where one of several scenes is refused, the program becomes one that bakes the rest: nothing less gives
//! back what other threads hold.
#![allow(unsafe_code)]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::io::Write;
use std::process::Command;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

/// The system's allocator, which never refuses: it ends the program instead.
struct OrEnd;

#[global_allocator]
static ALLOCATOR: OrEnd = OrEnd;

// SAFETY: every call goes to the system's allocator with the caller's own arguments, for which the caller keeps the
// rules of this trait; what comes back is returned as it is, or not at all.
unsafe impl GlobalAlloc for OrEnd {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: as above.
        given(unsafe { System.alloc(layout) }, layout.size())
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: as above.
        given(unsafe { System.alloc_zeroed(layout) }, layout.size())
    }

    unsafe fn realloc(&self, block: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: as above; `block` came from the same allocator.
        given(unsafe { System.realloc(block, layout, size) }, size)
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        // SAFETY: as above.
        unsafe { System.dealloc(block, layout) }
    }
}

#[inline]
fn given(block: *mut u8, size: usize) -> *mut u8 {
    if block.is_null() {
        end(size)
    }
    block
}

/// What is in work, and the program for what comes after it.
static IN_WORK: Mutex<Option<(String, Command)>> = Mutex::new(None);

/// From now on memory that is refused is told of with the name of what is in work, and `rest` runs in place of this
/// program.
pub fn in_work(name: String, rest: Command) {
    if let Ok(mut in_work) = IN_WORK.lock() {
        *in_work = Some((name, rest));
    }
}

/// Tells what was refused and ends the program, without asking for memory and without running what others left for its
/// end.
#[cold]
fn end(size: usize) -> ! {
    static ENDS: AtomicBool = AtomicBool::new(false);
    thread_local!(static MINE: Cell<bool> = const { Cell::new(false) });
    // The other threads may be refused too before the program has ended; one line is enough.
    while ENDS.swap(true, Ordering::SeqCst) {
        if MINE.get() {
            signal_hook::low_level::exit(1);
        }
        std::thread::yield_now();
    }
    MINE.set(true);
    let mut in_work = IN_WORK.try_lock().ok();
    let in_work = in_work.as_mut().and_then(|in_work| in_work.as_mut());
    let (name, colon) = (in_work.as_ref()).map_or(("", ""), |(name, _)| (name.as_str(), ": "));
    // Of a line that is too long the beginning is told.
    let mut line = [b'\n'; 1024];
    let most = line.len() - 1;
    let mut rest = &mut line[..most];
    let _ = write!(
        rest,
        "ambake: {name}{colon}the system refuses {size} more bytes of memory; raise its limit or take a smaller \
         `--size`; the same command goes on from what was saved"
    );
    let unused = rest.len();
    tell(&line[..=most - unused]);
    #[cfg(unix)]
    if let Some((_, rest)) = in_work {
        // It returns only where the program cannot be started.
        let _ = std::os::unix::process::CommandExt::exec(rest);
    }
    signal_hook::low_level::exit(1)
}

/// Writes to standard error past Rust's own handle of it, which this very thread may be using.
fn tell(line: &[u8]) {
    #[cfg(unix)]
    {
        use std::{fs::File, mem::ManuallyDrop, os::fd::FromRawFd};
        // SAFETY: 2 is open: where the program is started without it, Rust's runtime opens the null device there
        // before `main`, and nothing of ours closes it. The file is never dropped, so that it stays open.
        let mut error = ManuallyDrop::new(unsafe { File::from_raw_fd(2) });
        let _ = error.write_all(line);
    }
    #[cfg(not(unix))]
    let _ = std::io::stderr().write_all(line);
}
