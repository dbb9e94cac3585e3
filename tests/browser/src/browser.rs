//! A headless Chromium, driven over its DevTools protocol.

use std::io::{BufRead, BufReader};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use base64::Engine;
use serde_json::{Value, json};
use tungstenite::{Message, WebSocket, stream::MaybeTlsStream};

/// A browser with one page; ends with this value.
pub struct Browser {
    child: Child,
    socket: WebSocket<MaybeTlsStream<TcpStream>>,
    session: String,
    last: u64,
    /// Errors and exceptions of the page so far.
    pub complaints: Vec<String>,
    _profile: tempfile::TempDir,
}

/// Longest wait for anything.
pub const PATIENCE: Duration = Duration::from_secs(180);

impl Browser {
    /// Starts a browser whose page is `width` x `height`.
    pub fn start(width: u32, height: u32) -> Self {
        let profile = tempfile::tempdir().expect("a directory for the profile");
        let name = std::env::var("CHROMIUM").unwrap_or_else(|_| "chromium".into());
        let mut child = Command::new(name)
            .args(["--headless", "--no-sandbox", "--disable-gpu", "--disable-background-networking"])
            .args(["--disable-component-update", "--disable-sync", "--disable-quic"])
            .args(["--remote-debugging-port=0", "--no-first-run", "--hide-scrollbars"])
            // No name leads anywhere and no address but this machine's: there is no network.
            .arg("--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1")
            .arg(format!("--user-data-dir={}", profile.path().display()))
            .arg(format!("--window-size={width},{height}"))
            .arg("about:blank")
            .stderr(Stdio::piped())
            .stdout(Stdio::null())
            .spawn()
            .expect("chromium starts");
        let lines = BufReader::new(child.stderr.take().expect("a pipe")).lines();
        let address = lines
            .map_while(Result::ok)
            .find_map(|line| line.strip_prefix("DevTools listening on ").map(str::to_owned))
            .expect("chromium tells its address");
        let (socket, _) = tungstenite::connect(address).expect("chromium answers");
        let mut browser = Self {
            child,
            socket,
            session: String::new(),
            last: 0,
            complaints: Vec::new(),
            _profile: profile,
        };
        let targets = browser.call("Target.getTargets", json!({}));
        let page = targets["targetInfos"].as_array().into_iter().flatten().find(|t| t["type"] == "page");
        let page = page.expect("a page")["targetId"].clone();
        let attached = browser.call("Target.attachToTarget", json!({ "targetId": page, "flatten": true }));
        browser.session = attached["sessionId"].as_str().expect("a session").into();
        browser.call("Page.enable", json!({}));
        browser.call("Runtime.enable", json!({}));
        browser.call("Performance.enable", json!({ "timeDomain": "threadTicks" }));
        browser.size(width, height, false);
        browser
    }

    /// Calls a method of the protocol.
    pub fn call(&mut self, method: &str, parameters: Value) -> Value {
        self.last += 1;
        let id = self.last;
        let mut request = json!({ "id": id, "method": method, "params": parameters });
        if !self.session.is_empty() {
            request["sessionId"] = json!(self.session);
        }
        self.socket.send(Message::text(request.to_string())).expect("chromium listens");
        loop {
            let Message::Text(text) = self.socket.read().expect("chromium answers") else { continue };
            let answer: Value = serde_json::from_str(&text).expect("JSON");
            if answer["method"] == "Runtime.exceptionThrown" {
                self.complaints.push(answer["params"]["exceptionDetails"].to_string());
            }
            if answer["id"] == id {
                assert!(answer["error"].is_null(), "{method}: {}", answer["error"]);
                return answer["result"].clone();
            }
        }
    }

    /// Opens an address.
    pub fn open(&mut self, url: &str) {
        self.call("Page.navigate", json!({ "url": url }));
    }

    /// The value of an expression in the page, promises awaited.
    pub fn value(&mut self, expression: &str) -> Value {
        let how = json!({ "expression": expression, "returnByValue": true, "awaitPromise": true });
        let answer = self.call("Runtime.evaluate", how);
        assert!(answer["exceptionDetails"].is_null(), "{expression}: {}", answer["exceptionDetails"]);
        answer["result"]["value"].clone()
    }

    /// Waits until an expression is true.
    pub fn wait(&mut self, expression: &str) {
        let begun = Instant::now();
        // While a page loads it has no body yet; that is no fault.
        let asked =
            format!("(() => {{ try {{ return Boolean({expression}); }} catch {{ return false; }} }})()");
        while self.value(&asked) != true {
            let so_far = begun.elapsed();
            assert!(so_far < PATIENCE, "waited {so_far:?} for {expression}\n{:?}", self.complaints);
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    /// Clicks the element of a selector.
    pub fn click(&mut self, selector: &str) {
        self.wait(&format!("document.querySelector('{selector}')"));
        self.value(&format!("document.querySelector('{selector}').click()"));
    }

    /// Presses and lets go of a key; `text` is what it types, if anything.
    pub fn key(&mut self, key: &str, text: Option<&str>) {
        let code = match key {
            "Enter" => 13,
            "Tab" => 9,
            "Escape" => 27,
            "ArrowRight" => 39,
            "ArrowDown" => 40,
            _ => 0,
        };
        let mut down = json!({ "type": "keyDown", "key": key, "windowsVirtualKeyCode": code });
        if let Some(text) = text {
            down["text"] = json!(text);
        }
        self.call("Input.dispatchKeyEvent", down);
        self.call(
            "Input.dispatchKeyEvent",
            json!({ "type": "keyUp", "key": key, "windowsVirtualKeyCode": code }),
        );
    }

    /// Drags the mouse from one place of the page to another, CSS pixels.
    pub fn drag(&mut self, from: [f64; 2], to: [f64; 2]) {
        for (kind, [x, y], buttons) in [
            ("mouseMoved", from, 0),
            ("mousePressed", from, 1),
            ("mouseMoved", [0.5 * (from[0] + to[0]), to[1]], 1),
            ("mouseMoved", to, 1),
            ("mouseReleased", to, 0),
        ] {
            let button = if kind == "mouseMoved" { "none" } else { "left" };
            let event = json!({ "type": kind, "x": x, "y": y, "button": button, "buttons": buttons, "clickCount": 1 });
            self.call("Input.dispatchMouseEvent", event);
        }
    }

    /// Time that the page's thread has computed so far, ms: what else the machine does is not in it.
    pub fn computed_ms(&mut self) -> f64 {
        let metrics = self.call("Performance.getMetrics", json!({}));
        let all = metrics["metrics"].as_array().into_iter().flatten();
        let task = all.into_iter().find(|metric| metric["name"] == "TaskDuration").expect("a measured page");
        1e3 * task["value"].as_f64().expect("a time")
    }

    /// The number that an expression gives, or promises.
    pub fn number(&mut self, expression: &str) -> f64 {
        let value = self.value(&format!("(async () => Number(await ({expression})))()"));
        value.as_f64().unwrap_or_else(|| panic!("{expression} is {value}"))
    }

    /// The text of a selector's element.
    pub fn text(&mut self, selector: &str) -> String {
        let value = self.value(&format!("document.querySelector('{selector}').textContent"));
        value.as_str().unwrap_or_else(|| panic!("{selector} has no text")).to_owned()
    }

    /// Gives a file to a file input.
    pub fn give_file(&mut self, selector: &str, file: &Path) {
        let input = self.call(
            "Runtime.evaluate",
            json!({ "expression": format!("document.querySelector('{selector}')") }),
        );
        let id = input["result"]["objectId"].clone();
        self.call("DOM.setFileInputFiles", json!({ "files": [file], "objectId": id }));
    }

    /// Sets the size of the page.
    pub fn size(&mut self, width: u32, height: u32, mobile: bool) {
        let metrics = json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": mobile });
        self.call("Emulation.setDeviceMetricsOverride", metrics);
    }

    /// Lets the page think that the user likes `scheme`, light or dark.
    pub fn prefer(&mut self, scheme: &str) {
        let features = json!([{ "name": "prefers-color-scheme", "value": scheme }]);
        self.call("Emulation.setEmulatedMedia", json!({ "features": features }));
    }

    /// Keeps a picture of what a selector's element shows.
    pub fn screenshot(&mut self, selector: &str, name: &str) {
        self.value(&format!(
            "document.querySelector('{selector}').scrollIntoView({{ behavior: 'instant' }})"
        ));
        // Figures are drawn when they come near; then the picture is taken.
        std::thread::sleep(Duration::from_millis(900));
        let picture = self.call("Page.captureScreenshot", json!({ "format": "png" }));
        let data = picture["data"].as_str().expect("a picture");
        let bytes = base64::engine::general_purpose::STANDARD.decode(data).expect("base64");
        std::fs::write(crate::screenshots().join(name).with_extension("png"), bytes).expect("written");
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
