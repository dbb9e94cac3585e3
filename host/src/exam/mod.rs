//! The examination of the diagnosis on hidden cases.

pub mod case;
