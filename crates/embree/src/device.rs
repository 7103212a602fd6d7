//! A device: Embree's threads, its error state and the account of its memory.

use crate::{DeviceConfig, DeviceInfo, Error, Isa, Memory, Tasking, Version};
use embree4_sys as sys;
use std::ffi::{CString, c_int, c_void};
use std::fmt;
use std::ptr;
use std::sync::Arc;
use std::sync::atomic::{AtomicI64, Ordering};

/// Version of the headers that this was built with; `None` where it was built without Embree.
pub fn header_version() -> Option<Version> {
    Some(Version::from_packed(sys::RTC_VERSION))
}

/// An Embree device. Clones share it; scenes keep it alive.
///
/// With TBB the number of threads is a limit of the whole process: the last device made sets it.
#[derive(Clone)]
pub struct Device(Arc<Inner>);

struct Inner {
    raw: sys::RTCDevice,
    info: DeviceInfo,
    // Embree holds its address until `drop` takes the callback back. (An `Arc`: a box may not be pointed to while it
    // moves.)
    account: Arc<Account>,
}

/// Bytes allocated, counted by Embree's memory monitor.
struct Account {
    current: AtomicI64,
    peak: AtomicI64,
    limit: i64,
}

// SAFETY: an RTCDevice may be used and released from any thread. Creating geometries and scenes and reading errors and
// properties are its only uses here; Embree synchronises these, errors are kept per thread, the account is atomic.
unsafe impl Send for Inner {}
// SAFETY: as for Send; `Inner` is immutable once made.
unsafe impl Sync for Inner {}

impl Device {
    /// A new device.
    ///
    /// # Errors
    /// [`Error::NotBuilt`], [`Error::VersionMismatch`], [`Error::UnsupportedCpu`] where the CPU lacks the instruction
    /// set asked for, [`Error::UnusableLibrary`] where it culls back faces, [`Error::OutOfMemory`].
    pub fn new(config: &DeviceConfig) -> Result<Device, Error> {
        let mut text = format!("threads={}", config.threads);
        if let Some(isa) = config.isa {
            text += &format!(",isa={isa}");
        }
        let text =
            CString::new(text).expect("the configuration is made of numbers and fixed names");
        let (mut error, mut version): (c_int, c_int) = (0, 0);
        // SAFETY: the text ends with a NUL and lives across the call; both results are locals. Embree copies the text.
        let raw = unsafe { sys::ambake_new_device(text.as_ptr(), &mut error, &mut version) };
        let library = Version::from_packed(version.unsigned_abs());
        let headers = Version::from_packed(sys::RTC_VERSION);
        if raw.is_null() {
            return Err(match error {
                sys::AMBAKE_ERROR_VERSION => Error::VersionMismatch { headers, library },
                code if code == sys::RTC_ERROR_UNSUPPORTED_CPU as c_int => {
                    Error::UnsupportedCpu { isa: config.isa }
                }
                code => from_code(code, "making a device"),
            });
        }
        let limit = config
            .memory_limit
            .map_or(i64::MAX, |bytes| i64::try_from(bytes).unwrap_or(i64::MAX));
        let account = Arc::new(Account {
            current: AtomicI64::new(0),
            peak: AtomicI64::new(0),
            limit,
        });
        // SAFETY: `raw` is the device just made. `account` is owned by `Inner` below, whose `drop` takes the
        // callback back before it is freed; it is Sync, so TBB workers may call at once; `monitor` does not unwind.
        unsafe {
            let account = Arc::as_ptr(&account).cast_mut().cast();
            sys::rtcSetDeviceMemoryMonitorFunction(raw, Some(monitor), account);
        }
        let info = info(raw, config, library, headers);
        let device = Device(Arc::new(Inner { raw, info, account }));
        if info.backface_culling {
            return Err(Error::UnusableLibrary("culls back faces"));
        }
        device.check("making a device")?;
        Ok(device)
    }

    /// Versions and abilities of the library that was loaded.
    pub fn info(&self) -> DeviceInfo {
        self.0.info
    }

    /// Bytes that Embree holds for this device's scenes, now and at most so far.
    pub fn memory(&self) -> Memory {
        let bytes = |count: &AtomicI64| count.load(Ordering::Relaxed).max(0).unsigned_abs();
        Memory {
            current: bytes(&self.0.account.current),
            peak: bytes(&self.0.account.peak),
        }
    }

    pub(crate) fn raw(&self) -> sys::RTCDevice {
        self.0.raw
    }

    pub(crate) fn same(&self, other: &Device) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }

    /// The calling thread's first error since the last check. To be called after every call that sets something up, on
    /// the same thread.
    pub(crate) fn check(&self, during: &'static str) -> Result<(), Error> {
        // SAFETY: the device is alive as long as `self`; the call only reads and clears this thread's error.
        match unsafe { sys::ambake_take_error(self.0.raw) } {
            0 => Ok(()),
            code => Err(from_code(code, during)),
        }
    }
}

impl fmt::Debug for Device {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Device")
            .field("info", &self.0.info)
            .finish_non_exhaustive()
    }
}

impl Drop for Inner {
    fn drop(&mut self) {
        // SAFETY: scenes and geometries hold a clone of the device, so none is left and no build runs: the callback is
        // not running and is taken back before its account is freed. The handle is released once, here.
        unsafe {
            sys::rtcSetDeviceMemoryMonitorFunction(self.raw, None, ptr::null_mut());
            sys::rtcReleaseDevice(self.raw);
        }
    }
}

fn from_code(code: c_int, during: &'static str) -> Error {
    if code == sys::RTC_ERROR_OUT_OF_MEMORY as c_int {
        Error::OutOfMemory { during }
    } else {
        Error::Embree { code, during }
    }
}

/// Counts an allocation (`bytes > 0`) or a release, and refuses an allocation over the limit. `post` calls correct the
/// count after the fact and cannot be refused.
unsafe extern "C" fn monitor(account: *mut c_void, bytes: isize, post: bool) -> bool {
    // SAFETY: `account` is what `Inner` owns; its `Drop` takes this callback back before that is freed. All its
    // fields are atomic or constant, so calls from several threads may share it.
    let account = unsafe { &*account.cast::<Account>() };
    let bytes = bytes as i64;
    let now = account.current.fetch_add(bytes, Ordering::Relaxed) + bytes;
    if bytes > 0 && !post && now > account.limit {
        account.current.fetch_sub(bytes, Ordering::Relaxed);
        return false;
    }
    account.peak.fetch_max(now, Ordering::Relaxed);
    true
}

fn info(
    raw: sys::RTCDevice,
    config: &DeviceConfig,
    library: Version,
    headers: Version,
) -> DeviceInfo {
    // SAFETY: the device is alive; properties are read only. The constants come from the installed headers.
    let property = |id: sys::RTCDeviceProperty| unsafe { sys::ambake_property(raw, id as c_int) };
    let native_packet_8 = property(sys::RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED) != 0;
    let native_packet_16 = property(sys::RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED) != 0;
    DeviceInfo {
        library,
        headers,
        tasking: match property(sys::RTC_DEVICE_PROPERTY_TASKING_SYSTEM) {
            0 => Tasking::Internal,
            1 => Tasking::Tbb,
            2 => Tasking::Ppl,
            other => Tasking::Other(other),
        },
        native_packet_4: property(sys::RTC_DEVICE_PROPERTY_NATIVE_RAY4_SUPPORTED) != 0,
        native_packet_8,
        native_packet_16,
        filter_functions: property(sys::RTC_DEVICE_PROPERTY_FILTER_FUNCTION_SUPPORTED) != 0,
        ray_mask: property(sys::RTC_DEVICE_PROPERTY_RAY_MASK_SUPPORTED) != 0,
        backface_culling: property(sys::RTC_DEVICE_PROPERTY_BACKFACE_CULLING_ENABLED) != 0,
        isa: config
            .isa
            .unwrap_or_else(|| default_isa(native_packet_8, native_packet_16)),
    }
}

/// The instruction set that Embree chooses: native packets of 16 mean AVX-512, of 8 mean AVX or AVX2.
fn default_isa(native_packet_8: bool, native_packet_16: bool) -> Isa {
    let [sse42, avx2] = cpu();
    match (native_packet_8, native_packet_16) {
        (_, true) => Isa::Avx512,
        (true, _) if avx2 => Isa::Avx2,
        (true, _) => Isa::Avx,
        _ if sse42 => Isa::Sse42,
        _ => Isa::Sse2,
    }
}

#[cfg(target_arch = "x86_64")]
fn cpu() -> [bool; 2] {
    [
        std::arch::is_x86_feature_detected!("sse4.2"),
        std::arch::is_x86_feature_detected!("avx2") && std::arch::is_x86_feature_detected!("fma"),
    ]
}

#[cfg(not(target_arch = "x86_64"))]
fn cpu() -> [bool; 2] {
    [false; 2]
}
