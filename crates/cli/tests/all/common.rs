//! What the tests of the binary share: a small scene, temporary folders, ways to run and compare.

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};

/// A drop that swings in two dimensions: a fraction of a second of work per millisecond.
pub const SCENE: &str = r#"
format = 1
name = "small"
[domain]
dimension = 2
size = ["3 mm", "3 mm"]
resolution = 32
[liquid]
density = "1 g/cm^3"
kinematic_viscosity = "0.01 cm^2/s"
[[liquid.body]]
shape.perturbed_ball = { center = ["1.5 mm", "1.5 mm"], radius = "0.9 mm", mode = 2, amplitude = 0.2 }
[tension]
liquid_air = "72.8 mN/m"
[output]
duration = "20 ms"
frame_interval = "0.3 ms"
formats = ["ply"]
checkpoint_every = 1
"#;

/// A drop that spreads on a plate, and what is expected of its angle.
pub const PLATE: &str = r#"
format = 1
name = "plate"
[domain]
dimension = 2
size = ["3 mm", "3 mm"]
resolution = 32
[liquid]
density = "1 g/cm^3"
kinematic_viscosity = "0.05 cm^2/s"
[[liquid.body]]
shape.ball = { center = ["1.5 mm", "1.3 mm"], radius = "0.9 mm" }
[[solid]]
name = "plate"
shape.half_space = { point = ["1.5 mm", "0.83 mm"], normal = [0.1, 1.0] }
material.rigid = { fixed = true }
[tension]
liquid_air = "72.8 mN/m"
plate = { contact_angle = "60 deg" }
[output]
duration = "1.5 ms"
frame_interval = "0.3 ms"
formats = ["ply"]
checkpoint_every = 1
[expect]
contact_angle = { solid = "plate", value = "90 deg", tolerance = "80 deg" }
"#;

/// A temporary folder with the scene in it, removed at the end.
pub struct Place(pub PathBuf);

impl Place {
    pub fn new(name: &str) -> Self {
        let root = std::env::temp_dir().join(format!("meniscus-test-{name}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&root);
        std::fs::create_dir_all(&root).unwrap();
        std::fs::write(root.join("small.toml"), SCENE).unwrap();
        std::fs::write(root.join("plate.toml"), PLATE).unwrap();
        Self(root)
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    /// The binary with arguments separated by blanks.
    pub fn command(&self, line: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_meniscus"));
        command.current_dir(&self.0).args(line.split_whitespace()).env("NO_COLOR", "1");
        command.stdin(Stdio::null());
        command
    }

    pub fn run(&self, line: &str) -> Output {
        self.command(line).output().unwrap()
    }

    pub fn start(&self, line: &str) -> Child {
        self.command(line).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
    }

    /// Runs and expects an exit status; standard error.
    pub fn expect(&self, line: &str, status: i32) -> String {
        let output = self.run(line);
        let error = text(&output.stderr);
        assert_eq!(output.status.code(), Some(status), "`{line}` said:\n{}{error}", text(&output.stdout));
        error
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

pub fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// The message without line breaks and frames, to look for words in it.
pub fn words(message: &str) -> String {
    let plain: String = message.chars().map(|c| if "│╰╭─·×├▶".contains(c) { ' ' } else { c }).collect();
    plain.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The frames of a run: names and bytes.
pub fn frames(run: &Path) -> Vec<(String, Vec<u8>)> {
    let mut frames: Vec<_> = std::fs::read_dir(run.join("frames"))
        .unwrap()
        .map(|e| e.unwrap().path())
        .map(|p| (p.file_name().unwrap().to_string_lossy().into_owned(), std::fs::read(&p).unwrap()))
        .collect();
    frames.sort();
    frames
}

/// The time series without its `wall_seconds`.
pub fn series(run: &Path) -> Vec<String> {
    let text = std::fs::read_to_string(run.join("timeseries.csv")).unwrap();
    let column = text.lines().next().unwrap().split(',').position(|c| c == "wall_seconds").unwrap();
    let without = |line: &str| {
        let cells: Vec<&str> =
            line.split(',').enumerate().filter(|(i, _)| *i != column).map(|(_, c)| c).collect();
        cells.join(",")
    };
    text.lines().map(without).collect()
}

/// Whether two runs are the same but for the clock.
pub fn assert_same(a: &Path, b: &Path) {
    let (fa, fb) = (frames(a), frames(b));
    let names = |f: &[(String, Vec<u8>)]| f.iter().map(|(n, _)| n.clone()).collect::<Vec<_>>();
    assert_eq!(names(&fa), names(&fb));
    for ((name, a), (_, b)) in fa.iter().zip(&fb) {
        assert!(a == b, "{name} differs");
    }
    let (sa, sb) = (series(a), series(b));
    assert_eq!(sa.len(), sb.len());
    for (a, b) in sa.iter().zip(&sb) {
        assert_eq!(a, b);
    }
}

/// Waits until the run has written so many rows.
pub fn wait_for_frames(run: &Path, count: usize) {
    wait_for(|| std::fs::read_dir(run.join("frames")).map_or(0, Iterator::count) >= count);
}

/// Waits until something is so, for a minute at most.
pub fn wait_for(mut is_so: impl FnMut() -> bool) {
    for _ in 0..3000 {
        if is_so() {
            return;
        }
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    panic!("what the test waits for did not come in a minute");
}

/// Sends a signal.
pub fn signal(child: &Child, name: &str) {
    let id = child.id().to_string();
    assert!(Command::new("kill").args([&format!("-{name}"), &id]).status().unwrap().success());
}
