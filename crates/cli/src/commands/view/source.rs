//! What `meniscus view` shows: a run in its folder, or the first frame of a scene that has not run. Both are looked at again as their
//! files change.

use crate::args::{SceneArgs, ViewArgs};
use crate::failure::{Failure, OUTPUT, Result, USAGE};
use crate::scenes;
use meniscus_scene::estimate::check::check;
use meniscus_scene::output::Folder;
use meniscus_scene::run::{ExistingRun, SilentObserver, Stop};
use meniscus_view::LiveRun;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::SystemTime;

/// The data from which the server answers until the files change.
#[derive(Clone)]
pub struct Shown {
    /// A number that changes with the content.
    pub version: u64,
    /// `waiting` for the first frame, `ready`, or `error`.
    pub state: &'static str,
    data: Arc<Value>,
    error: Option<Value>,
    report: Option<String>,
    runs: [Option<Arc<LiveRun>>; 2],
}

impl Shown {
    /// The document of the page: its state, the data of the runs, the report of a scene's check, and the error.
    pub fn document(&self) -> Value {
        json!({
            "version": self.version, "state": self.state, "error": self.error, "report": self.report, "runs": *self.data,
        })
    }

    /// The run that an address `0/…` or `1/…` names, and the rest of the address.
    pub fn run<'a>(&self, address: &'a str) -> Option<(&LiveRun, &'a str)> {
        let (number, rest) = address.split_once('/')?;
        let run = self.runs.get(number.parse::<usize>().ok()?)?.as_ref()?;
        Some((run, rest))
    }
}

/// The files that are shown.
pub struct Source {
    /// The scene whose first frame is shown; none for a run.
    preview: Option<Preview>,
    /// The folders of the runs: the one that is shown, and the one that is drawn over it.
    runs: [Option<(PathBuf, LiveRun)>; 2],
    seen: Option<Vec<Stamp>>,
    shown: Shown,
}

/// When a file was last changed, and its length; none if there is no such file.
type Stamp = Option<(SystemTime, u64)>;

impl Source {
    /// What the arguments ask for.
    ///
    /// # Errors
    /// A failure of status 4 for what does not exist, 2 for settings of a run; a wrong scene is shown, not refused.
    pub fn new(args: &ViewArgs) -> Result<Self> {
        let path = Path::new(&args.scene.scene);
        let over = args.with.as_ref().map(|dir| folder(dir)).transpose()?;
        if path.is_dir() && (!args.scene.set.is_empty() || args.scene.quality.is_some()) {
            let failure = Failure::new(
                USAGE,
                format!("`{}` is a run, which --set and --quality do not change", path.display()),
            );
            return Err(failure.help("leave them out, or give the scene"));
        }
        if !path.exists() {
            // A built-in scene; or the error of what is neither.
            scenes::load(&args.scene, &[])?;
        }
        let preview = (!path.is_dir()).then(|| Preview::new(&args.scene)).transpose()?;
        let first = preview.as_ref().map_or(path, |preview| &preview.folder).to_path_buf();
        let run = |dir: PathBuf, number: usize| (dir.clone(), LiveRun::new(&dir, &format!("mesh/{number}")));
        let shown = Shown {
            version: 0,
            state: "waiting",
            data: Arc::new(json!([])),
            error: None,
            report: None,
            runs: [None, None],
        };
        let runs = [Some(run(first, 0)), over.map(|dir| run(dir, 1))];
        Ok(Self { preview, runs, seen: None, shown })
    }

    /// What is to be shown now.
    pub fn shown(&self) -> Shown {
        self.shown.clone()
    }

    /// Looks at the files. Returns whether something else is to be shown.
    pub fn look(&mut self) -> bool {
        let seen = self.stamps();
        if self.seen.as_ref() == Some(&seen) {
            return false;
        }
        self.seen = Some(seen);
        let done = self.update();
        self.shown.version += 1;
        match done {
            Ok(data) => {
                self.shown.state = if data.is_empty() { "waiting" } else { "ready" };
                self.shown.data = Arc::new(Value::Array(data));
                self.shown.error = None;
                self.shown.runs =
                    std::array::from_fn(|i| self.runs[i].as_ref().map(|run| Arc::new(run.1.clone())));
            }
            // The last good state stays in sight.
            Err(failure) => {
                self.shown.state = "error";
                self.shown.error = Some(told(&failure));
            }
        }
        true
    }

    /// The stamps of the files whose change means another picture.
    fn stamps(&self) -> Vec<Stamp> {
        let of_run =
            |dir: &PathBuf| [dir.join("frames"), dir.join("summary.json"), dir.join("timeseries.csv")];
        match &self.preview {
            Some(preview) => preview.files.iter().map(|path| stamp(path)).collect(),
            None => {
                self.runs.iter().flatten().flat_map(|(dir, _)| of_run(dir)).map(|path| stamp(&path)).collect()
            }
        }
    }

    /// The data of the runs; nothing if there is no frame yet.
    fn update(&mut self) -> Result<Vec<Value>> {
        if let Some(preview) = &mut self.preview {
            self.shown.report = Some(preview.build()?);
            let (dir, run) = (preview.folder.clone(), LiveRun::new(&preview.folder, "mesh/0"));
            self.runs[0] = Some((dir, run));
        }
        let mut data = Vec::new();
        for (dir, run) in self.runs.iter_mut().flatten() {
            if !has_frames(dir) {
                return Ok(Vec::new());
            }
            data.push(run.data().map_err(|e| Failure::new(OUTPUT, e.to_string()))?);
        }
        Ok(data)
    }
}

/// The first frame of a scene, in a folder of its own.
struct Preview {
    scene: SceneArgs,
    folder: PathBuf,
    /// The files whose change means another frame: the scene and the meshes that it names.
    files: Vec<PathBuf>,
}

impl Preview {
    fn new(scene: &SceneArgs) -> Result<Self> {
        let folder = std::env::temp_dir().join(format!("meniscus-view-{}", std::process::id()));
        std::fs::create_dir_all(&folder).map_err(Failure::file("make", &folder))?;
        Ok(Self { scene: scene.clone(), folder, files: vec![PathBuf::from(&scene.scene)] })
    }

    /// Checks the scene and writes its first frame. Returns the report of the check.
    fn build(&mut self) -> Result<String> {
        let scene = scenes::load(&self.scene, &[])?.scene;
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        let report = check(&scene, threads);
        let text = report.render();
        if let Some(error) = report.error {
            return Err(error.into());
        }
        scenes::check_runnable(&scene)?;
        self.files.truncate(1);
        self.files.extend(scene.files.paths());
        let (setup, job) = scenes::prepare(&scene)?;
        let folder = Folder::at(&self.folder);
        setup.run(&job, &folder, ExistingRun::Replace, &|| Some(Stop::Caller), &mut SilentObserver)?;
        Ok(text)
    }
}

impl Drop for Preview {
    fn drop(&mut self) {
        // Whatever stays is in the folder for temporary files.
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}

fn folder(dir: &Path) -> Result<PathBuf> {
    if dir.is_dir() {
        return Ok(dir.to_path_buf());
    }
    let failure = Failure::new(OUTPUT, format!("there is no folder `{}`", dir.display()));
    Err(failure.help("give the output folder of a run"))
}

fn has_frames(dir: &Path) -> bool {
    std::fs::read_dir(dir.join("frames")).is_ok_and(|mut files| files.next().is_some())
}

fn stamp(path: &Path) -> Stamp {
    let file = path.metadata().ok()?;
    Some((file.modified().ok()?, file.len()))
}

/// A failure as the page shows it.
fn told(failure: &Failure) -> Value {
    let place = failure.place();
    json!({
        "message": failure.to_string(),
        "help": failure.help_text(),
        "file": place.map(|place| place.file),
        "line": place.map(|place| place.line),
        "column": place.map(|place| place.column),
        "text": place.map(|place| place.text),
    })
}
