//! motorlens
