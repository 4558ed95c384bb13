//! The tests of the program and of its library, in one program: those of two files go side by side.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

#[cfg_attr(not(unix), allow(dead_code))]
mod common;
mod exports;
#[cfg(target_os = "linux")]
mod failed_writes;
mod inputs;
mod readme;
#[cfg(unix)]
mod runs;
mod sabotage;
#[cfg(unix)]
mod sweep;
#[cfg(unix)]
mod view;
