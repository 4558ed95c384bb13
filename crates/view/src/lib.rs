//! Meniscus view.
