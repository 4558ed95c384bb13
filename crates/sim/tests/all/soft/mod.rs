//! Solids that deform: contacts, folds, Newton's iterations, the tension of their surface.

pub mod collide;
mod fold;
mod newton;
mod tension;
