//! A library to preload: the n-th write, sync or rename of a file below a folder fails with an error of the device (EIO).
//!
//! `FAIL_UNDER` is the folder, `FAIL_AT` is n, from 1; when the call fails, the path of its file is written into the file `FAILED`. The test compiles it with `rustc`; it needs nothing but the C library.

use std::ffi::{CStr, OsStr, c_char, c_int, c_void};
use std::os::unix::ffi::OsStrExt;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};

/// Input or output error.
const EIO: c_int = 5;
/// The next library after this one.
const RTLD_NEXT: *mut c_void = -1isize as *mut c_void;

unsafe extern "C" {
    fn dlsym(handle: *mut c_void, name: *const c_char) -> *mut c_void;
    fn __errno_location() -> *mut c_int;
}

/// Calls so far.
static CALLS: AtomicU64 = AtomicU64::new(0);

/// The folder and the number of the call that fails.
fn plan() -> Option<&'static (PathBuf, u64)> {
    static PLAN: OnceLock<Option<(PathBuf, u64)>> = OnceLock::new();
    PLAN.get_or_init(|| {
        let folder = std::env::var_os("FAIL_UNDER")?;
        Some((PathBuf::from(folder), std::env::var("FAIL_AT").ok()?.parse().ok()?))
    })
    .as_ref()
}

/// Counts a call for this file, and tells whether it is the one that fails.
fn fails(path: &Path) -> bool {
    let Some((folder, at)) = plan() else { return false };
    if !path.starts_with(folder) || CALLS.fetch_add(1, Ordering::Relaxed) + 1 != *at {
        return false;
    }
    let _ = std::env::var_os("FAILED").map(|told| std::fs::write(told, path.as_os_str().as_bytes()));
    // SAFETY: the C library's own place for the error of this thread.
    unsafe { *__errno_location() = EIO };
    true
}

fn fails_at(file: c_int) -> bool {
    file > 2 && std::fs::read_link(format!("/proc/self/fd/{file}")).is_ok_and(|path| fails(&path))
}

/// A function of the next library.
///
/// # Safety
/// `F` is the function's type.
unsafe fn next<F: Copy>(name: &CStr) -> F {
    // SAFETY: a pointer to a function has the size of a pointer.
    unsafe { std::mem::transmute_copy(&dlsym(RTLD_NEXT, name.as_ptr())) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn write(file: c_int, bytes: *const c_void, count: usize) -> isize {
    if fails_at(file) {
        return -1;
    }
    // SAFETY: the arguments are those of the caller.
    unsafe { next::<unsafe extern "C" fn(c_int, *const c_void, usize) -> isize>(c"write")(file, bytes, count) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fsync(file: c_int) -> c_int {
    if fails_at(file) {
        return -1;
    }
    // SAFETY: as above.
    unsafe { next::<unsafe extern "C" fn(c_int) -> c_int>(c"fsync")(file) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn fdatasync(file: c_int) -> c_int {
    if fails_at(file) {
        return -1;
    }
    // SAFETY: as above.
    unsafe { next::<unsafe extern "C" fn(c_int) -> c_int>(c"fdatasync")(file) }
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn rename(from: *const c_char, to: *const c_char) -> c_int {
    // SAFETY: the caller gives strings that end with a zero.
    let path = Path::new(OsStr::from_bytes(unsafe { CStr::from_ptr(to) }.to_bytes()));
    if fails(&std::path::absolute(path).unwrap_or_default()) {
        return -1;
    }
    // SAFETY: as above.
    unsafe { next::<unsafe extern "C" fn(*const c_char, *const c_char) -> c_int>(c"rename")(from, to) }
}
