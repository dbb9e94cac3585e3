//! What cannot be done, as Python's exceptions.

use motorlens::Error;
use pyo3::create_exception;
use pyo3::exceptions::{PyException, PyKeyboardInterrupt};
use pyo3::prelude::*;

create_exception!(
    _native,
    MotorlensError,
    PyException,
    "Input that cannot be used: where, why, and what to do."
);

pub(crate) fn failed(error: &Error) -> PyErr {
    match error {
        Error::Cancelled => PyKeyboardInterrupt::new_err(()),
        other => MotorlensError::new_err(other.to_string()),
    }
}

pub(crate) fn refused(why: impl Into<String>, remedy: &str) -> PyErr {
    failed(&Error::usage(why.into(), remedy))
}
