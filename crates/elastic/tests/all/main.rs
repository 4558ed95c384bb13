//! The tests of this crate's public face, in one program: every program of its own compiles the generic functions anew.
#![allow(clippy::unwrap_used)]

mod cantilever;
mod derivatives;
mod elements;
mod energy;
mod lattice;
mod plates;
mod refusals;
mod turek_hron;
