//! Meniscus validation.
