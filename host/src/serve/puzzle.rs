//! Records of a virtual motor with effects that nobody chose: the demo's, and the puzzle's.

use std::sync::Arc;
use std::time::{SystemTime, UNIX_EPOCH};

use axum::Json;
use axum::extract::State;
use axum::http::StatusCode;
use clap::{Args, FromArgMatches};
use serde::Deserialize;
use serde_json::json;

use super::App;
use super::jobs::{self, Answer, End, refused};
use super::session::{Puzzle, Session};
use crate::error::{Error, Result};
use crate::simulate::{self, Role, SimulateArgs};

/// The session of the demo's records.
///
/// # Errors
/// None that a user can cause.
pub fn demo() -> Result<Session> {
    hidden(simulate::DEMO)
}

/// A session of records with the effects that `seed` picks.
fn hidden(seed: u64) -> Result<Session> {
    let command = SimulateArgs::augment_args(clap::Command::new("simulate"));
    let args = command
        .try_get_matches_from(["simulate", "--hidden", &seed.to_string()])
        .and_then(|m| SimulateArgs::from_arg_matches(&m))
        .map_err(|e| Error::usage(e.to_string(), "take another seed"))?;
    let scenario = args.scenario()?;
    let plays = args.plays(scenario.motor.nominal_v)?;
    let (mut records, mut validation) = (Vec::new(), Vec::new());
    for (play, record) in plays.iter().zip(scenario.records(&plays)?) {
        if play.role == Role::HeldOut { validation.push(record) } else { records.push(record) }
    }
    // Beside the logs on the disk lies a motor file: without it the same motor would be fitted otherwise than by the other verbs.
    let mut session = Session::new(records, validation, simulate::data_sheet(&scenario)?)?;
    session.puzzle = Some(Puzzle { answer: simulate::Answer::of(&scenario), revealed: false });
    Ok(session)
}

/// A puzzle's number, where one is wished for.
#[derive(Debug, Deserialize)]
pub struct Wish {
    seed: Option<u64>,
}

/// Replaces the records by those of a new puzzle.
pub async fn start(State(app): State<Arc<App>>, Json(wish): Json<Wish>) -> Answer {
    let now = SystemTime::now().duration_since(UNIX_EPOCH).map_or(1, |d| d.subsec_nanos());
    let seed = wish.seed.unwrap_or_else(|| u64::from(now) % 100_000);
    jobs::start(&app, &format!("Hiding effects, puzzle {seed}"), move |_| match hidden(seed) {
        Ok(new) => End::Done(
            format!("Puzzle {seed}: what is this motor's model missing?"),
            Box::new(move |session| *session = new),
        ),
        Err(error) => End::Failed(error.to_json()),
    })
}

/// Shows what is hidden.
pub async fn reveal(State(app): State<Arc<App>>) -> Answer {
    let mut session = app.session();
    let found: Vec<String> = session.current.kinds().iter().map(ToString::to_string).collect();
    match &mut session.puzzle {
        Some(puzzle) => {
            puzzle.revealed = true;
            Ok(Json(json!({ "answer": puzzle.answer, "found": found })))
        }
        None => Err(refused(StatusCode::CONFLICT, "these records are no puzzle")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_puzzle_knows_of_its_motor_what_the_logs_on_the_disk_tell() {
        let motor = demo().unwrap().data.motor;
        assert!(motor.gear_ratio.is_some() && motor.nameplate.inductance_h.is_some(), "{motor:?}");
    }
}
