//! `meniscus view`: a server that shows a run, or a scene that is saved again and again, to browsers of this machine alone.

use crate::common::{Place, signal, wait_for, words};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::Child;

/// A running server.
struct Server {
    child: Child,
    port: u16,
}

impl Server {
    fn start(place: &Place, line: &str) -> Self {
        let mut child = place.start(line);
        let mut first = String::new();
        BufReader::new(child.stdout.as_mut().unwrap()).read_line(&mut first).unwrap();
        let port = first.trim().strip_prefix("http://127.0.0.1:").unwrap().strip_suffix('/').unwrap();
        Self { child, port: port.parse().unwrap() }
    }

    /// Status and text of the answer to a request.
    fn ask(&self, method: &str, path: &str, host: &str) -> (u16, String) {
        let mut stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        write!(stream, "{method} {path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n").unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        let (head, text) = answer.split_once("\r\n\r\n").unwrap();
        (head.split(' ').nth(1).unwrap().parse().unwrap(), text.to_owned())
    }

    fn get(&self, path: &str) -> (u16, String) {
        self.ask("GET", path, &format!("127.0.0.1:{}", self.port))
    }

    fn json(&self, path: &str) -> serde_json::Value {
        let (status, text) = self.get(path);
        assert_eq!(status, 200, "{path}: {text}");
        serde_json::from_str(&text).unwrap()
    }

    fn wait_for_state(&self, state: &str) -> serde_json::Value {
        wait_for(|| self.json("/state")["state"] == state);
        self.json("/data")
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        signal(&self.child, "TERM");
        assert!(self.child.wait().unwrap().success(), "a signal ends the server as it should");
    }
}

#[test]
fn a_run_is_shown_while_it_goes_on() {
    let place = Place::new("view-run");
    place.expect("run plate.toml --out a --quiet", 0);
    place.expect("run plate.toml --out b --set tension.plate.contact_angle=120deg --until 1ms --quiet", 0);
    let server = Server::start(&place, "view a --with b");
    let all = server.wait_for_state("ready");
    let run = &all["runs"][0];
    assert_eq!((run["dimension"].as_u64(), all["runs"].as_array().unwrap().len()), (Some(2), 2));
    let last = run["frames"].as_array().unwrap().last().unwrap();
    for part in [&last["liquid"], &last["line"], &last["solids"]["plate"]] {
        let (status, mesh) = server.get(&format!("/{}", part.as_str().unwrap()));
        assert!(status == 200 && mesh.len() > 40, "{part}: {mesh}");
    }
    let line = server.json(&format!("/line/0/{}/contact_line", last["number"]));
    assert_eq!((line["positions"].as_array().unwrap().len(), &line["solids"][0]), (2, &"plate".into()));
    assert!(line["values"]["angle"][0].as_f64().unwrap() > 10.0);

    // Frames that come later are shown.
    let before = run["frames"].as_array().unwrap().len();
    for name in ["liquid", "solid_plate"] {
        let file = |n: usize| place.path(&format!("a/frames/{name}_{n:04}.ply"));
        std::fs::copy(file(before - 1), file(before)).unwrap();
    }
    wait_for(|| server.json("/data")["runs"][0]["frames"].as_array().unwrap().len() == before + 1);

    // Nothing but the run is served, and to this machine's own browsers only.
    for path in
        ["/mesh/0/1/../../summary", "/mesh/0/1/solid_other?", "/mesh/9/1/liquid?", "/../Cargo.toml", "/x"]
    {
        assert_eq!(server.get(path).0, 404, "{path}");
    }
    assert_eq!(server.ask("GET", "/data", "evil.example").0, 403);
    assert_eq!(server.ask("POST", "/data", &format!("localhost:{}", server.port)).0, 405);
    let (status, page) = server.get("/");
    assert!(status == 200 && page.contains("{\"live\":true}"));
}

#[test]
fn a_scene_is_shown_as_it_is_saved() {
    let place = Place::new("view-scene");
    let server = Server::start(&place, "view plate.toml");
    let all = server.wait_for_state("ready");
    assert_eq!(all["runs"][0]["frames"].as_array().unwrap().len(), 1);
    assert!(all["report"].as_str().unwrap().contains("angle on plate"));
    let text = std::fs::read_to_string(place.path("plate.toml")).unwrap();
    std::fs::write(place.path("plate.toml"), text.replace("liquid_air", "liquid_ar")).unwrap();
    let all = server.wait_for_state("error");
    let error = &all["error"];
    assert!(
        error["help"].as_str().unwrap().contains("contact_angle") && error["text"] == "\"72.8 mN/m\"",
        "{error}"
    );
    assert!(
        error["line"].as_u64().unwrap() > 1 && error["file"].as_str().unwrap().ends_with("plate.toml"),
        "{error}"
    );
    assert_eq!(all["runs"].as_array().unwrap().len(), 1, "the last good state stays");
    std::fs::write(place.path("plate.toml"), text.replace("0.9 mm", "0.8 mm")).unwrap();
    server.wait_for_state("ready");
}

#[test]
fn wrong_views_are_refused() {
    let place = Place::new("no-view");
    assert!(
        words(&place.expect("view plate.toml --with nowhere", 4)).contains("there is no folder `nowhere`")
    );
    assert!(words(&place.expect("view out/nowhere", 4)).contains("out/nowhere"));
    std::fs::create_dir(place.path("empty")).unwrap();
    assert!(words(&place.expect("view empty --set domain.resolution=3", 2)).contains("--set"));
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let line = format!("view plate.toml --port {}", taken.local_addr().unwrap().port());
    assert!(words(&place.expect(&line, 4)).contains("cannot listen on port"));
}
