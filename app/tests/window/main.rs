//! The window driven by real input events, and looked at from outside: by its picture, its title, and the files it writes.
//!
//! Needs an X display, `xdotool` and ImageMagick's `import`; `tests/run` provides them and makes their absence a failure.

#![allow(clippy::unwrap_used)] // A helper that fails fails its test.

mod crash;
mod editing;
mod hands;
mod journey;
