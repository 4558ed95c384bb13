//! Meniscus sim.
