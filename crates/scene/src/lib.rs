//! Meniscus scene.
