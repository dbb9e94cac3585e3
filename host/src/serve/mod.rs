//! The live page: the five steps of the work in a browser, on this machine only.
//!
//! The server listens on the loopback address, and answers only requests that name it by that address and come
//! from its own page, so that no other page open in the browser can drive it. One [`session::Session`] holds
//! records and models; long work runs in one thread at a time and tells of itself in server-sent events.

mod answers;
mod data;
mod device;
mod diagnosis;
mod effect_file;
mod field;
mod fields;
mod fits;
mod guard;
mod jobs;
mod open;
mod origin;
mod puzzle;
mod rig;
mod runs;
mod scene;
mod session;
mod slide;
mod steps;
mod upload;
mod view;

use std::net::{Ipv4Addr, SocketAddr};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use axum::extract::DefaultBodyLimit;
use axum::routing::{get, post};
use axum::{Router, middleware};
use motorlens_shared::effects::Kind;
use serde_json::Value;
use tokio::sync::broadcast;

pub use puzzle::demo;
pub use session::Session;

use crate::error::{Error, Result};
use crate::formula::Library;

/// Largest log that the page takes, bytes.
const LARGEST_UPLOAD: usize = 200_000_000;

/// What all requests share.
#[derive(Debug)]
pub struct App {
    session: Mutex<Session>,
    /// What this page may use: it outlives the session, which new records replace.
    library: Mutex<Library>,
    events: broadcast::Sender<Value>,
    job: Mutex<Option<Arc<jobs::Running>>>,
    device: Mutex<Option<device::Device>>,
    uploaded: Mutex<Vec<data::Entry>>,
}

impl App {
    fn new(session: Session, library: Library) -> Self {
        Self {
            session: Mutex::new(session),
            library: Mutex::new(library),
            events: broadcast::channel(1024).0,
            job: Mutex::new(None),
            device: Mutex::new(None),
            uploaded: Mutex::new(Vec::new()),
        }
    }

    fn library(&self) -> MutexGuard<'_, Library> {
        self.library.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Lets this page use `kind`.
    fn offer(&self, kind: Kind) -> Result<()> {
        let mut library = self.library();
        *library = library.clone().with(kind)?;
        Ok(())
    }

    fn session(&self) -> MutexGuard<'_, Session> {
        self.session.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn device(&self) -> MutexGuard<'_, Option<device::Device>> {
        self.device.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn uploaded(&self) -> MutexGuard<'_, Vec<data::Entry>> {
        self.uploaded.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn tell(&self, event: Value) {
        // Nobody may be listening; then nobody needs to know.
        let _ = self.events.send(event);
    }
}

/// Serves `session` until the process ends, with the effects of `library` to choose from; `ready` gets the address once it listens. Port 0
/// takes any free one.
///
/// # Errors
/// The port is taken, or the machine refuses to listen.
pub fn serve(session: Session, library: Library, port: u16, ready: impl FnOnce(SocketAddr)) -> Result<()> {
    let io = |doing: &str| {
        let doing = doing.to_owned();
        move |source| Error::Io { doing, source }
    };
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .worker_threads(4)
        .enable_all()
        .build()
        .map_err(io("cannot start the server"))?;
    runtime.block_on(async {
        let listener = tokio::net::TcpListener::bind((Ipv4Addr::LOCALHOST, port))
            .await
            .map_err(io(&format!("cannot listen on port {port}; try --port 0")))?;
        let address = listener.local_addr().map_err(io("cannot listen"))?;
        ready(address);
        let stop = async {
            let _ = tokio::signal::ctrl_c().await;
        };
        tokio::select! {
            served = axum::serve(listener, router(App::new(session, library), address.port())) => served.map_err(io("the server failed")),
            () = stop => Ok(()),
        }
    })
}

fn router(app: App, port: u16) -> Router {
    Router::new()
        .route("/", get(answers::page))
        .route("/script/{name}", get(answers::script))
        .route("/style.css", get(answers::style))
        .route("/api/state", get(answers::state))
        .route("/api/figures/{step}", get(answers::figures))
        .route("/api/record/{number}", get(answers::record))
        .route("/api/events", get(answers::events))
        .route("/api/slide", post(slide::slide))
        .route("/api/diagnose", post(fits::diagnose))
        .route("/api/add", post(fits::add))
        .route("/api/remove", post(fits::remove))
        .route("/api/stop", post(jobs::stop))
        .route("/api/guess", post(upload::guess))
        .route("/api/upload", post(upload::upload))
        .route("/api/use", post(upload::take))
        .route("/api/mapping/{entry}", get(upload::mapping))
        .route("/api/map", post(upload::map))
        .route("/api/data", post(data::change))
        .route("/api/effect", post(effect_file::offer))
        .route("/api/against", post(answers::against))
        .route("/api/glossary", get(answers::glossary))
        .route("/api/puzzle", post(puzzle::start))
        .route("/api/reveal", post(puzzle::reveal))
        .route("/api/device/ports", get(device::ports))
        .route("/api/device/connect", post(device::connect))
        .route("/api/device/disconnect", post(device::disconnect))
        .route("/api/device/run", post(runs::run))
        .route("/export/programme.json", get(answers::programme))
        .route("/export/model.json", get(answers::model))
        .route("/export/report.html", get(answers::report))
        .layer(DefaultBodyLimit::max(LARGEST_UPLOAD))
        .layer(middleware::from_fn_with_state(port, guard::same_page_only))
        .with_state(Arc::new(app))
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_page_refuses_by_itself_what_the_server_would_not_take() {
        let script = include_str!("assets/log.js");
        assert!(script.contains(&format!("const LARGEST = {};", super::LARGEST_UPLOAD)));
    }
}
