//! Open Image Denoise, loaded while running: never needed, never linked. Interface: `oidn.h` of version 2.
//!
//! `unsafe` stands here because functions of a foreign library are called. What they are told holds: pointers live as long as the filter
//! that reads them, sizes are those of the slices, and every object that was made is released once.

use super::Guides;
use libloading::{Library, Symbol};
use std::ffi::{CStr, OsStr, c_char, c_int, c_void};
use std::fmt;
use std::path::{Path, PathBuf};
use std::ptr;

/// Environment variable with the library or the folder that holds it.
pub const LIBRARY_VARIABLE: &str = "BURNISH_OIDN";

#[cfg(target_os = "windows")]
const NAMES: [&str; 1] = ["OpenImageDenoise.dll"];
#[cfg(target_os = "macos")]
const NAMES: [&str; 2] = ["libOpenImageDenoise.2.dylib", "libOpenImageDenoise.dylib"];
#[cfg(not(any(target_os = "windows", target_os = "macos")))]
const NAMES: [&str; 2] = ["libOpenImageDenoise.so.2", "libOpenImageDenoise.so"];

/// `OIDN_DEVICE_TYPE_CPU`: pointers to our memory can be read by no other.
const DEVICE_CPU: c_int = 1;
/// `OIDN_FORMAT_FLOAT3`.
const FLOAT3: c_int = 3;

type Handle = *mut c_void;
type NewDevice = unsafe extern "C" fn(c_int) -> Handle;
type OfHandle = unsafe extern "C" fn(Handle);
type GetInt = unsafe extern "C" fn(Handle, *const c_char) -> c_int;
type GetError = unsafe extern "C" fn(Handle, *mut *const c_char) -> c_int;
type NewFilter = unsafe extern "C" fn(Handle, *const c_char) -> Handle;
type SetImage = unsafe extern "C" fn(Handle, *const c_char, *mut c_void, c_int, usize, usize, usize, usize, usize);
type SetBool = unsafe extern "C" fn(Handle, *const c_char, bool);

/// Why Open Image Denoise cannot be used; shown to the user as one sentence.
#[derive(Debug)]
pub enum OidnError {
    /// No library was found.
    Missing {
        /// Where it was looked for.
        tried: Vec<PathBuf>,
        /// What the system said about the last.
        problem: String,
    },
    /// The library lacks a function of version 2.
    OtherVersion {
        /// The library.
        path: PathBuf,
        /// What is missing.
        problem: String,
    },
    /// It reported an error.
    Failed {
        /// Its own words.
        problem: String,
    },
}

impl fmt::Display for OidnError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Missing { tried, problem } => {
                let tried: Vec<String> = tried.iter().map(|path| path.display().to_string()).collect();
                write!(
                    f,
                    "Open Image Denoise: expected the library {} ({LIBRARY_VARIABLE} tells where): {problem}",
                    tried.join(" or ")
                )
            }
            Self::OtherVersion { path, problem } => {
                write!(f, "Open Image Denoise: {}: expected version 2: {problem}", path.display())
            }
            Self::Failed { problem } => write!(f, "Open Image Denoise: {problem}"),
        }
    }
}

impl std::error::Error for OidnError {}

/// The functions that are used.
#[derive(Debug)]
struct Functions {
    release_device: OfHandle,
    get_error: GetError,
    new_filter: NewFilter,
    set_image: SetImage,
    set_bool: SetBool,
    commit_filter: OfHandle,
    execute_filter: OfHandle,
    release_filter: OfHandle,
}

/// A device of the library, on the processor.
#[derive(Debug)]
pub struct Oidn {
    functions: Functions,
    device: Handle,
    version: String,
    /// Keeps the functions in memory; last, so that it goes last.
    _library: Library,
}

// SAFETY: the library's objects may be used by any thread, and by one at a time without further care; `filter` takes a lock of the
// library's own in every call (documentation, "Device": all functions are thread-safe unless stated otherwise).
#[expect(unsafe_code, reason = "the handle is a pointer that the library lets any thread use")]
unsafe impl Send for Oidn {}
// SAFETY: as above.
#[expect(unsafe_code, reason = "the handle is a pointer that the library lets any thread use")]
unsafe impl Sync for Oidn {}

impl Oidn {
    /// The library at `place`, a file or a folder, or else where the system looks for libraries.
    ///
    /// # Errors
    /// [`OidnError`] where there is none or it does not work.
    pub fn load(place: Option<&OsStr>) -> Result<Self, OidnError> {
        let tried: Vec<PathBuf> = match place.map(Path::new) {
            Some(folder) if folder.is_dir() => NAMES.iter().map(|name| folder.join(name)).collect(),
            Some(file) => vec![file.to_path_buf()],
            None => NAMES.iter().map(PathBuf::from).collect(),
        };
        let mut problem = String::new();
        for path in &tried {
            // SAFETY: running a library's initialisation is what the user asks for by installing or naming it.
            #[expect(unsafe_code, reason = "loads a foreign library")]
            match unsafe { Library::new(path) } {
                Ok(library) => return Self::of(library, path),
                Err(error) => problem = error.to_string(),
            }
        }
        Err(OidnError::Missing { tried, problem })
    }

    /// The library where [`LIBRARY_VARIABLE`] says, or else where the system looks.
    ///
    /// # Errors
    /// As [`Self::load`].
    pub fn find() -> Result<Self, OidnError> {
        Self::load(std::env::var_os(LIBRARY_VARIABLE).filter(|place| !place.is_empty()).as_deref())
    }

    /// A number such as `2.5.1`.
    pub fn version(&self) -> &str {
        &self.version
    }

    fn of(library: Library, path: &Path) -> Result<Self, OidnError> {
        /// A function of a library. The caller names its type as in `oidn.h`.
        fn symbol<T: Copy>(library: &Library, name: &str) -> Result<T, libloading::Error> {
            // SAFETY: the types at the call below are those of `oidn.h`; the pointer is kept no longer than the library.
            #[expect(unsafe_code, reason = "a function of a foreign library has the type that its header says")]
            unsafe {
                library.get(name.as_bytes()).map(|found: Symbol<'_, T>| *found)
            }
        }
        let other = |error: libloading::Error| OidnError::OtherVersion { path: path.to_path_buf(), problem: error.to_string() };
        let functions = Functions {
            release_device: symbol(&library, "oidnReleaseDevice").map_err(other)?,
            get_error: symbol(&library, "oidnGetDeviceError").map_err(other)?,
            new_filter: symbol(&library, "oidnNewFilter").map_err(other)?,
            set_image: symbol(&library, "oidnSetSharedFilterImage").map_err(other)?,
            set_bool: symbol(&library, "oidnSetFilterBool").map_err(other)?,
            commit_filter: symbol(&library, "oidnCommitFilter").map_err(other)?,
            execute_filter: symbol(&library, "oidnExecuteFilter").map_err(other)?,
            release_filter: symbol(&library, "oidnReleaseFilter").map_err(other)?,
        };
        let new_device: NewDevice = symbol(&library, "oidnNewDevice").map_err(other)?;
        let commit_device: OfHandle = symbol(&library, "oidnCommitDevice").map_err(other)?;
        let get_int: GetInt = symbol(&library, "oidnGetDeviceInt").map_err(other)?;
        // SAFETY: the device is used before it is released, and the name is a C text.
        #[expect(unsafe_code, reason = "calls functions of a foreign library")]
        let (device, number) = unsafe {
            let device = new_device(DEVICE_CPU);
            if device.is_null() {
                return Err(OidnError::Failed { problem: functions.error(ptr::null_mut()) });
            }
            commit_device(device);
            (device, get_int(device, c"version".as_ptr()))
        };
        let version = format!("{}.{}.{}", number / 10_000, number / 100 % 100, number % 100);
        let found = Self { functions, device, version, _library: library };
        found.check()?;
        Ok(found)
    }

    /// Filters linear radiance, guided by albedo and normal where they have as many pixels.
    pub(super) fn filter(
        &self,
        color: &[[f32; 3]],
        guides: &Guides,
        width: usize,
        height: usize,
    ) -> Result<Vec<[f32; 3]>, OidnError> {
        let mut out = vec![[0.0_f32; 3]; width * height];
        if color.len() != out.len() || color.is_empty() {
            return Ok(out);
        }
        let Functions { new_filter, set_image, set_bool, commit_filter, execute_filter, release_filter, .. } = self.functions;
        let mut images = vec![(c"color", color.as_ptr().cast_mut()), (c"output", out.as_mut_ptr())];
        if guides.albedo.len() == color.len() && guides.normal.len() == color.len() {
            images.push((c"albedo", guides.albedo.as_ptr().cast_mut()));
            images.push((c"normal", guides.normal.as_ptr().cast_mut()));
        }
        // SAFETY: all images hold `width * height` pixels of three floats without gaps, are written only if named "output", and outlive
        // the filter, which is released here; execution has ended when the call returns.
        #[expect(unsafe_code, reason = "calls functions of a foreign library")]
        unsafe {
            let filter = new_filter(self.device, c"RT".as_ptr());
            if filter.is_null() {
                return Err(OidnError::Failed { problem: self.functions.error(self.device) });
            }
            for (name, pixels) in images {
                set_image(filter, name.as_ptr(), pixels.cast(), FLOAT3, width, height, 0, 0, 0);
            }
            set_bool(filter, c"hdr".as_ptr(), true);
            commit_filter(filter);
            execute_filter(filter);
            release_filter(filter);
        }
        self.check()?;
        for x in out.iter_mut().flatten() {
            *x = if x.is_finite() { *x } else { 0.0 };
        }
        Ok(out)
    }

    /// What went wrong since the last check.
    fn check(&self) -> Result<(), OidnError> {
        let problem = self.functions.error(self.device);
        if problem.is_empty() { Ok(()) } else { Err(OidnError::Failed { problem }) }
    }
}

impl Functions {
    /// The first unread error of a device, or of making one if it is null; empty if there is none.
    fn error(&self, device: Handle) -> String {
        let mut message: *const c_char = ptr::null();
        // SAFETY: the library writes a pointer to a C text of its own, which lives until the next call.
        #[expect(unsafe_code, reason = "calls a function of a foreign library and reads its text")]
        unsafe {
            match (self.get_error)(device, &raw mut message) {
                0 => String::new(),
                code if message.is_null() => format!("error {code}"),
                _ => CStr::from_ptr(message).to_string_lossy().into_owned(),
            }
        }
    }
}

impl Drop for Oidn {
    fn drop(&mut self) {
        // SAFETY: made in `of`, released once.
        #[expect(unsafe_code, reason = "calls a function of a foreign library")]
        unsafe {
            (self.functions.release_device)(self.device);
        }
    }
}
