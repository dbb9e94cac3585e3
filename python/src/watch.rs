//! Long calls: Ctrl-C is heeded, progress is told, other threads of Python run meanwhile.

use std::ops::ControlFlow;
use std::sync::Mutex;

use motorlens::Event;
use pyo3::prelude::*;
use serde_json::{Value, json};

use crate::fault::failed;

/// Watches for Ctrl-C and hands events to `progress`; an exception there stops the search and goes on from here.
pub(crate) fn watched<T: Send>(
    py: Python,
    progress: Option<Py<PyAny>>,
    work: impl FnOnce(&mut dyn FnMut(&Event) -> ControlFlow<()>) -> motorlens::Result<T> + Send,
) -> PyResult<T> {
    let raised: Mutex<Option<PyErr>> = Mutex::new(None);
    let done = py.detach(|| {
        work(&mut |event| {
            let told = Python::attach(|py| {
                py.check_signals()?;
                if let (Some(call), Some(event)) = (&progress, told(event)) {
                    call.call1(py, (event.to_string(),))?;
                }
                PyResult::Ok(())
            });
            match told {
                Ok(()) => ControlFlow::Continue(()),
                Err(error) => {
                    if let Ok(mut place) = raised.lock() {
                        *place = Some(error);
                    }
                    ControlFlow::Break(())
                }
            }
        })
    });
    match (done, raised.into_inner().unwrap_or_default()) {
        (_, Some(raised)) => Err(raised),
        (done, None) => done.map_err(|e| failed(&e)),
    }
}

pub(crate) fn told(event: &Event) -> Option<Value> {
    match event {
        Event::Waiting => None,
        Event::Trying { depth, effect } => Some(json!({ "trying": effect, "depth": depth })),
        Event::Model { effects, rmse } => Some(json!({ "effects": effects, "rmse": rmse })),
        Event::Running { share } => Some(json!({ "share": share })),
        Event::Generation { number, iae } => Some(json!({ "generation": number, "iae": iae })),
    }
}
