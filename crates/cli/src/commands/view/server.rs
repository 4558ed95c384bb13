//! A server for browsers on this machine.
//!
//! It listens on 127.0.0.1 only, and answers only requests whose `Host` header names this address, so that no page of another site
//! can read from it (DNS rebinding). The page is allowed no addresses but those of this server.

use super::source::Shown;
use crate::failure::{Failure, OUTPUT, Result};
use serde_json::{Value, json};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;
use tiny_http::{Header, Method, Request, Response};

/// Threads that answer.
pub const THREADS: usize = 4;

/// Longest wait for a request before a look at whether to stop.
const WAIT: Duration = Duration::from_millis(200);

/// The page's content security policy: it may load nothing but its own scripts and styles and the data of this server.
const POLICY: &str = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; \
                      img-src data: blob:; connect-src 'self'; base-uri 'none'; form-action 'none'";

/// The server.
pub struct Server {
    http: tiny_http::Server,
    port: u16,
}

/// An answer: status, type, text.
type Answer = (u16, &'static str, String);

impl Server {
    /// Listens on a port of 127.0.0.1; 0 is any free one.
    ///
    /// # Errors
    /// A failure of status 4 if the port cannot be had.
    pub fn open(port: u16) -> Result<Self> {
        let refused = |e: &dyn std::fmt::Display| {
            Failure::new(OUTPUT, format!("cannot listen on port {port} of 127.0.0.1: {e}"))
                .help("give another port with --port, or leave it out for any free one")
        };
        let http = tiny_http::Server::http(("127.0.0.1", port)).map_err(|e| refused(&e))?;
        let port = http.server_addr().to_ip().map_or(port, |address| address.port());
        Ok(Self { http, port })
    }

    /// Its address for a browser.
    pub fn address(&self) -> String {
        format!("http://127.0.0.1:{}/", self.port)
    }

    /// Answers requests until `stop`.
    pub fn answer(&self, shown: &Mutex<Shown>, stop: &dyn Fn() -> bool) {
        while !stop() {
            let Ok(Some(request)) = self.http.recv_timeout(WAIT) else { continue };
            let (status, kind, text) = self.answer_to(&request, shown);
            let fields = [
                ("Content-Type", kind),
                ("Content-Security-Policy", POLICY),
                ("X-Content-Type-Options", "nosniff"),
                ("Cache-Control", "no-store"),
            ];
            let headers = fields.iter().filter_map(|(name, value)| Header::from_bytes(*name, *value).ok());
            let response =
                headers.fold(Response::from_string(text).with_status_code(status), Response::with_header);
            // A browser that has left is no failure.
            let _ = request.respond(response);
        }
    }

    fn answer_to(&self, request: &Request, shown: &Mutex<Shown>) -> Answer {
        let hosts = [format!("127.0.0.1:{}", self.port), format!("localhost:{}", self.port)];
        let host = request.headers().iter().find(|header| header.field.equiv("Host"));
        if !host.is_some_and(|header| hosts.iter().any(|host| *host == header.value.as_str())) {
            return plain(403, "this server answers only to its own address");
        }
        if *request.method() != Method::Get {
            return plain(405, "only GET is answered");
        }
        let shown = shown.lock().unwrap_or_else(PoisonError::into_inner).clone();
        let path = request.url().trim_start_matches('/');
        match path.split_once('/') {
            None if path.is_empty() => (200, "text/html; charset=utf-8", meniscus_view::live_page()),
            None if path == "state" => data(Some(json!({ "version": shown.version, "state": shown.state }))),
            None if path == "data" => data(Some(shown.document())),
            Some(("line", rest)) => data(shown.run(rest).and_then(|(run, rest)| run.line_points(rest))),
            Some(("mesh", rest)) => match shown.run(rest).and_then(|(run, rest)| run.packed_mesh(rest)) {
                Some(mesh) => (200, "text/plain; charset=utf-8", mesh),
                None => plain(404, "there is no such mesh"),
            },
            _ => plain(404, "there is nothing here"),
        }
    }
}

fn plain(status: u16, text: &str) -> Answer {
    (status, "text/plain; charset=utf-8", text.to_owned())
}

fn data(value: Option<Value>) -> Answer {
    match value {
        Some(value) => (200, "application/json", value.to_string()),
        None => plain(404, "there is no such data"),
    }
}
