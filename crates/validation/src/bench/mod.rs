//! Problems of `meniscus bench`.

pub mod precision;
pub mod pressure;
