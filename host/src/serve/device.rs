//! The board, or the virtual bench, that the page is connected to.

use std::sync::Arc;

use axum::Json;
use axum::extract::State;
use axum::http::StatusCode;
use motorlens_shared::link::{FromBoard, ToBoard};
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::App;
use super::jobs::{Answer, refused};
use crate::device::{Fault, Inquiry, Port};
use crate::error::{Error, Result};

/// A board that has answered. The line is opened anew for each conversation, so that other programs may use it
/// between them.
#[derive(Debug, Clone, Serialize)]
pub struct Device {
    /// A serial port, or `tcp://host:port`.
    pub port: String,
    /// Version of its firmware.
    firmware: String,
    /// Its own number.
    unique: String,
    /// Whether it measures its supply as it was set up last; else the user states it.
    measures_supply: bool,
    /// Whether it measures the current as it was set up last.
    measures_current: bool,
    /// Whether it can be told what is wired; else no limit on the current can be kept.
    converter: bool,
}

impl Device {
    /// Greets the board at `port`.
    ///
    /// # Errors
    /// The port cannot be opened, or what is there does not answer as a board.
    fn greet(port: &str) -> Result<Self> {
        let answers = ask(&mut Port::open(port)?, [ToBoard::Capabilities])?;
        let [FromBoard::Hello(hello), FromBoard::Capabilities(can)] = &answers[..] else {
            return Err(Fault::Confused.into());
        };
        Ok(Self {
            port: port.into(),
            firmware: hello.firmware.map(|part| part.to_string()).join("."),
            unique: hello.unique.iter().map(|byte| format!("{byte:02x}")).collect(),
            measures_supply: can.measures_supply,
            measures_current: can.measures_current,
            converter: can.converter,
        })
    }
}

/// Greets the board and asks these; the answers, the greeting's first.
///
/// # Errors
/// The line breaks, or the board is silent or refuses.
pub fn ask(port: &mut Port, requests: impl IntoIterator<Item = ToBoard>) -> Result<Vec<FromBoard>> {
    let mut inquiry = Inquiry::new(requests);
    let answers = port.converse(|now, received, send| {
        inquiry.receive(received, now);
        inquiry.poll(now, send);
        inquiry.take_outcome()
    })?;
    Ok(answers?)
}

/// An error as the page gets it.
pub fn unreachable(error: &Error) -> (StatusCode, Json<serde_json::Value>) {
    (StatusCode::BAD_GATEWAY, Json(error.to_json()))
}

/// Serial ports that one could name.
pub async fn ports() -> Answer {
    let ports = serial2::SerialPort::available_ports().unwrap_or_default();
    let names: Vec<String> = ports.iter().map(|port| port.display().to_string()).collect();
    Ok(Json(json!({ "ports": names })))
}

/// Where the board is.
#[derive(Debug, Deserialize)]
pub struct Place {
    port: String,
}

/// Greets the board and keeps its place.
pub async fn connect(State(app): State<Arc<App>>, Json(place): Json<Place>) -> Answer {
    let device = tokio::task::block_in_place(|| Device::greet(place.port.trim()));
    let device = device.map_err(|error| unreachable(&error))?;
    let answer = json!(device);
    *app.device() = Some(device);
    Ok(Json(answer))
}

/// Forgets the board.
pub async fn disconnect(State(app): State<Arc<App>>) -> Answer {
    match app.device().take() {
        Some(_) => Ok(Json(json!({ "connected": false }))),
        None => Err(refused(StatusCode::CONFLICT, "no board is connected")),
    }
}
