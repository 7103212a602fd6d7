//! The test of hits on masked triangles: a Rust closure behind the shim's C callback, Embree's filter function.

use crate::Keep;
use embree4_sys as sys;
use std::any::Any;
use std::cell::RefCell;
use std::ffi::c_void;
use std::panic::{self, AssertUnwindSafe};
use std::ptr::{self, NonNull};

/// A closure, and the record that Embree's geometry points to, at one fixed address.
pub(crate) struct HitTest(NonNull<Record>);

struct Record {
    /// What the shim reads; its `closure` points to `keep`.
    shim: sys::ambake_filter,
    keep: Keep,
}

// SAFETY: a `HitTest` owns its record, as a box would; the closure in it is Send + Sync and is only read.
unsafe impl Send for HitTest {}
// SAFETY: as for Send.
unsafe impl Sync for HitTest {}

impl HitTest {
    /// A test; Embree may point to its record until it is dropped, wherever the `HitTest` moves.
    pub(crate) fn new(keep: Keep) -> HitTest {
        let shim = sys::ambake_filter {
            keep: Some(call),
            closure: ptr::null(),
        };
        let record = NonNull::from(Box::leak(Box::new(Record { shim, keep })));
        // SAFETY: the record was just made and nobody else knows it. Its fields keep their addresses until `drop`.
        unsafe { (*record.as_ptr()).shim.closure = (&raw const (*record.as_ptr()).keep).cast() };
        HitTest(record)
    }

    pub(crate) fn record(&self) -> *const sys::ambake_filter {
        // SAFETY: the record lives until `drop`; only an address is taken.
        unsafe { &raw const (*self.0.as_ptr()).shim }
    }
}

impl Drop for HitTest {
    fn drop(&mut self) {
        // SAFETY: the record comes from a box and is freed once, here. The owner (builder or scene) has released the
        // geometry or scene that could call it.
        drop(unsafe { Box::from_raw(self.0.as_ptr()) });
    }
}

thread_local! {
    /// What a closure panicked with during the query that this thread runs.
    static PANIC: RefCell<Option<Box<dyn Any + Send>>> = const { RefCell::new(None) };
}

/// Continues a panic that a closure raised during this thread's query. Embree's frames never unwind: `call` stops the
/// panic before them and this takes it up after them.
pub(crate) fn resume() {
    if let Some(payload) = PANIC.with_borrow_mut(Option::take) {
        panic::resume_unwind(payload);
    }
}

/// Runs the closure. After a panic every further hit of the query is kept, so that it ends soon.
unsafe extern "C" fn call(
    closure: *const c_void,
    primitive: u32,
    u: f32,
    v: f32,
    ray: u32,
) -> bool {
    // SAFETY: `closure` is the `Keep` of a `HitTest` that the scene owns; a query borrows the scene, and queries are
    // the only callers. The closure is Sync, so several threads may call it.
    let keep = unsafe { &*closure.cast::<Keep>() };
    if PANIC.with_borrow(Option::is_some) {
        return true;
    }
    match panic::catch_unwind(AssertUnwindSafe(|| keep(primitive, [u, v], ray))) {
        Ok(kept) => kept,
        Err(payload) => {
            PANIC.set(Some(payload));
            true
        }
    }
}
