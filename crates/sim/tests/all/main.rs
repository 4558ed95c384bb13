//! The tests of this crate's public face, in one program: every program of its own compiles the whole simulation anew.

mod collisions;
mod contact_line;
mod free_surface;
mod friction;
mod patterns;
mod repairs;
mod soft;
mod solids;
mod steps;
mod walls;
