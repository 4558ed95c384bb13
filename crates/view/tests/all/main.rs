//! The tests of this crate's public face, in one program: every program of its own compiles the whole simulation anew.

mod bent;
mod common;
mod measure;
mod pictures;
