//! Sweeps: cases are runs like any other, in any number of processes, stopped and continued; thresholds are found.

use crate::common::{Place, assert_same, signal, text, wait_for, wait_for_frames, words};
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::time::SystemTime;

/// A drop that falls: its speed after 3 ms is 3 ms times gravity.
const FALL: &str = r#"
format = 1
name = "fall"
domain = { dimension = 2, size = ["3 mm", "3 mm"], resolution = 16 }
liquid = { density = "1 g/cm^3", kinematic_viscosity = "0.01 cm^2/s", gravity = [0, "-1 m/s^2"], body = [
  { shape.ball = { center = ["1.5 mm", "1.5 mm"], radius = "0.8 mm" } } ] }
tension = { liquid_air = "1 mN/m" }
numerics = { max_step = "20 us" }
output = { duration = "3 ms", frame_interval = "1 ms", formats = ["ply"], checkpoint_every = 1 }
expect = { max_speed = { max = "1.5 cm/s" } }
"#;

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap()
}

/// Rows of a CSV file without quotes.
fn table(path: &Path) -> Vec<Vec<String>> {
    read(path).lines().map(|line| line.split(',').map(String::from).collect()).collect()
}

fn column(rows: &[Vec<String>], name: &str) -> Vec<String> {
    let at =
        rows[0].iter().position(|head| head == name).unwrap_or_else(|| panic!("{name} in {:?}", rows[0]));
    rows[1..].iter().map(|row| row[at].clone()).collect()
}

fn written(path: &Path) -> SystemTime {
    path.metadata().unwrap().modified().unwrap()
}

#[test]
fn cases_are_runs_and_make_a_table_and_a_phase_map() {
    let place = Place::new("sweep");
    let line = "sweep plate.toml --set output.duration=0.6ms --vary tension.plate.contact_angle=60deg,120deg \
                --vary liquid.density=1:2:2g/cm^3 --jobs 2 --out all";
    let output = place.run(line);
    let said = text(&output.stdout) + &text(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert!(said.contains("[4/4]") && said.contains("all/sweep.csv"), "{said}");
    let all = place.path("all");
    let rows = table(&all.join("sweep.csv"));
    assert_eq!(
        rows[0][..5],
        ["case", "tension.plate.contact_angle (deg)", "liquid.density (g/cm^3)", "state", "met"]
    );
    assert_eq!(column(&rows, "tension.plate.contact_angle (deg)"), ["60", "60", "120", "120"]);
    assert_eq!(column(&rows, "liquid.density (g/cm^3)"), ["1", "2", "1", "2"]);
    assert_eq!(column(&rows, "state"), ["finished"; 4]);
    assert_eq!(column(&rows, "contact_angle.plate met"), ["1"; 4]);
    let angles: Vec<f64> =
        column(&rows, "contact_angle.plate (deg)").iter().map(|cell| cell.parse().unwrap()).collect();
    assert!(angles[0] < angles[2] && angles[1] < angles[3], "{angles:?}");
    let page = read(&all.join("index.html"));
    assert!(
        page.contains("<svg") && page.contains("contact_angle.plate") && !page.contains("http"),
        "phase map"
    );

    // A case has the bits of the run with its settings.
    place.expect(
        "run plate.toml --set output.duration=0.6ms --set tension.plate.contact_angle=120deg \
         --set liquid.density=2g/cm^3 --out single --quiet",
        0,
    );
    assert_same(&place.path("single"), &all.join("case_0003"));

    // The same command does nothing again; other values are refused, in the folder and as its own sweep.
    let before = written(&all.join("case_0000/summary.json"));
    place.expect(line, 0);
    assert_eq!(written(&all.join("case_0000/summary.json")), before);
    let refusal = words(&place.expect(&line.replace("1:2:2", "1:3:2"), 4));
    assert!(refusal.contains("contains another sweep") && refusal.contains("--out"), "{refusal}");
    let refusal = words(&place.expect(&line.replace("0.6ms", "0.9ms"), 4));
    assert!(refusal.contains("contains another sweep"), "{refusal}");
}

#[test]
fn a_single_case_has_the_status_of_its_run() {
    let place = Place::new("case");
    std::fs::write(place.path("fall.toml"), FALL).unwrap();
    let line = "sweep fall.toml --vary liquid.gravity.1=-1:-7:3m/s^2";
    place.expect(&format!("{line} --case 0 --quiet"), 0);
    let missed = place.expect(&format!("{line} --case 2 --quiet"), 6);
    assert!(missed.contains("largest speed"), "{missed}");
    let folder = place.path("out/fall-sweep");
    assert!(!folder.join("case_0001").exists());
    let said = words(&place.expect("sweep out/fall-sweep --collect", 0));
    assert!(said.is_empty(), "{said}");
    let rows = table(&folder.join("sweep.csv"));
    assert_eq!(column(&rows, "state"), ["finished", "not started", "finished"]);
    assert_eq!(column(&rows, "met"), ["1", "", "0"]);
    assert_eq!(column(&rows, "liquid.gravity.1 (m/s^2)"), ["-1", "-4", "-7"]);
    // The folder goes on with the case that is missing, and its status is the gravest.
    place.expect("sweep out/fall-sweep --quiet", 6);
    assert_eq!(column(&table(&folder.join("sweep.csv")), "met"), ["1", "1", "0"]);
    let refusal = words(&place.expect("sweep out/fall-sweep --case 3", 2));
    assert!(refusal.contains("no case 3") && refusal.contains("0 to 2"), "{refusal}");
}

#[test]
fn a_stopped_sweep_goes_on_with_the_same_bits() {
    let place = Place::new("stop");
    let line = "sweep small.toml --set output.duration=6ms --vary liquid.density=1,2g/cm^3 --jobs 2";
    place.expect(&format!("{line} --out whole --quiet"), 0);
    let child = place.start(&format!("{line} --set numerics.max_step=0.2us --out slow"));
    for case in ["case_0000", "case_0001"] {
        wait_for_frames(&place.path("slow").join(case), 1);
    }
    signal(&child, "TERM");
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(75), "{}", text(&output.stderr));
    assert!(text(&output.stderr).contains("the same command goes on"));
    assert_eq!(column(&table(&place.path("slow/sweep.csv")), "state"), ["stopped: signal"; 2]);

    // Killed, its cases go on to their end; the next process waits for them.
    for frames in [0, 2] {
        let mut child = place.start(&format!("{line} --out killed"));
        wait_for(|| place.path("killed/case_0001.log").exists());
        wait_for_frames(&place.path("killed/case_0000"), frames);
        child.kill().unwrap();
        child.wait().unwrap();
    }
    place.expect(&format!("{line} --out killed --quiet"), 0);
    for case in ["case_0000", "case_0001"] {
        assert_same(&place.path("whole").join(case), &place.path("killed").join(case));
    }
    place.expect(&format!("{line} --set numerics.max_step=0.2us --walltime 0.3s --out late --quiet"), 75);
}

#[test]
fn a_threshold_is_found_and_the_search_survives_a_kill() {
    let place = Place::new("find");
    std::fs::write(place.path("fall.toml"), FALL).unwrap();
    let line = "sweep fall.toml --find max_speed --vary liquid.gravity.1=-1:-12m/s^2";
    let mut child = place.start(line);
    wait_for_frames(&place.path("out/fall-find/case_0002"), 1);
    child.kill().unwrap();
    child.wait().unwrap();
    let folder = place.path("out/fall-find");
    let before = written(&folder.join("case_0000/summary.json"));
    let output = place.run(line);
    let said = text(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{said}{}", text(&output.stderr));
    assert!(said.contains("threshold liquid.gravity.1 = -"), "{said}");
    assert_eq!(written(&folder.join("case_0000/summary.json")), before, "a finished case is not run again");
    let found: serde_json::Value = serde_json::from_str(&read(&folder.join("find.json"))).unwrap();
    let number = |key: &str| found[key].as_f64().unwrap();
    // 1.5 cm/s in 3 ms.
    assert!((number("threshold") + 5.0).abs() < 0.02 * 5.0, "{found}");
    assert!(number("uncertainty") <= 0.01 * 5.1 && number("met_at") > number("missed_at"), "{found}");
    let rows = table(&folder.join("sweep.csv"));
    assert_eq!(rows.len() - 1, found["cases"].as_array().unwrap().len());
    assert!((8..=10).contains(&rows.len()), "{} rows", rows.len());
    // A smaller tolerance goes on from there.
    place.expect(&format!("{line} --tolerance 0.005 --quiet"), 0);
    let finer: serde_json::Value = serde_json::from_str(&read(&folder.join("find.json"))).unwrap();
    assert!(finer["uncertainty"].as_f64().unwrap() <= 0.0025 * 5.1, "{finer}");
    assert!(words(&place.expect("sweep out/fall-find", 2)).contains("--collect"));
    place.expect("sweep out/fall-find --collect --quiet", 0);
    let refusal = words(
        &place.expect("sweep fall.toml --find max_speed --vary liquid.gravity.1=-1:-2m/s^2 --out b", 6),
    );
    assert!(refusal.contains("met at both ends"), "{refusal}");
}

#[test]
fn a_budget_chooses_the_resolution() {
    let place = Place::new("budget");
    std::fs::write(place.path("fall.toml"), FALL).unwrap();
    let cells = |time: &str, out: &str| {
        let line =
            format!("sweep fall.toml --vary liquid.gravity.1=-1,-4m/s^2 --budget {time} --out {out} --slurm");
        let said = place.run(&line);
        assert_eq!(said.status.code(), Some(0), "{}", text(&said.stderr));
        let scene = read(&place.path(out).join("case_0001.toml"));
        scene.lines().find_map(|line| line.strip_prefix("resolution = ")).unwrap().parse::<u32>().unwrap()
    };
    let [less, more] = [cells("3s", "less"), cells("30s", "more")];
    assert!(16 < less && less < more && more <= 1024, "{less} {more}");
    assert_eq!(cells("30s", "less"), less, "a sweep keeps its resolution");
    let refusal =
        words(&place.expect("sweep fall.toml --vary liquid.gravity.1=-1,-4m/s^2 --budget 0.000001s", 2));
    assert!(refusal.contains("longer than the budget with 16 cells"), "{refusal}");
}

#[test]
fn a_slurm_array_runs_the_cases_and_requeues_them() {
    let place = Place::new("slurm");
    std::fs::write(place.path("fall.toml"), FALL).unwrap();
    let said = place.run("sweep fall.toml --vary liquid.gravity.1=-1:-4:2m/s^2 --slurm --threads 1");
    assert!(text(&said.stdout).contains("sbatch out/fall-sweep/run.sbatch"), "{}", text(&said.stdout));
    let script = place.path("out/fall-sweep/run.sbatch");
    for part in ["--array=0-1\n", "--signal=USR1@120\n", "--requeue\n", "--cpus-per-task=1\n"] {
        assert!(read(&script).contains(&format!("#SBATCH {part}")), "{part}");
    }
    // Programs of Slurm, as far as the script asks for them.
    let bin = place.path("bin");
    std::fs::create_dir(&bin).unwrap();
    for (name, body) in [("srun", "exec \"$@\" $MORE"), ("scontrol", "echo \"$@\" >> \"$REQUEUED\"")] {
        std::fs::write(bin.join(name), format!("#!/bin/sh\n{body}\n")).unwrap();
        std::fs::set_permissions(bin.join(name), std::fs::Permissions::from_mode(0o755)).unwrap();
    }
    let path = format!("{}:{}", bin.display(), std::env::var("PATH").unwrap());
    let task = |number: &str, more: &str| {
        let mut command = std::process::Command::new("bash");
        command.arg(&script).current_dir("/").env("PATH", &path).env("REQUEUED", place.path("requeued"));
        command.env("MENISCUS", env!("CARGO_BIN_EXE_meniscus")).env("MORE", more).env("SLURM_JOB_ID", "17");
        command.env("SLURM_ARRAY_TASK_ID", number).output().unwrap()
    };
    let output = task("1", "--walltime 0.01s");
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert_eq!(read(&place.path("requeued")).trim(), "requeue 17");
    for number in ["0", "1"] {
        assert_eq!(task(number, "").status.code(), Some(0));
    }
    place.expect("sweep out/fall-sweep --collect --quiet", 0);
    assert_eq!(column(&table(&place.path("out/fall-sweep/sweep.csv")), "state"), ["finished"; 2]);
    assert_eq!(read(&place.path("requeued")).lines().count(), 1);
}

#[test]
fn wrong_sweeps_are_refused_before_anything_runs() {
    let place = Place::new("no-sweep");
    let refused = |line: &str, status: i32, parts: &[&str]| {
        let said = words(&place.expect(line, status));
        parts
            .iter()
            .for_each(|part| assert!(said.contains(part), "`{line}` should say `{part}`, but says:\n{said}"));
        assert!(!place.path("out").exists(), "`{line}` has written something");
    };
    refused("sweep small.toml", 2, &["nothing is varied", "--vary"]);
    refused("sweep small.toml --vary liquid.density", 2, &["--vary", "PATH=VALUES"]);
    refused("sweep small.toml --vary liquid.density=1:2:1g/cm^3", 2, &["number of values"]);
    refused("sweep small.toml --vary a=1,2 --vary a=3,4", 2, &["varied twice"]);
    refused("sweep small.toml --vary a=1:2:200 --vary b=1:2:200", 2, &["more than 10000 cases"]);
    refused(
        "sweep small.toml --vary liquid.densty=1:2:3g/cm^3",
        3,
        &["densty", "did you mean `density`?", "--set"],
    );
    refused("sweep small.toml --vary liquid.density=1:2:3mm", 3, &["1 mm", "a density", "--set"]);
    refused("sweep small.toml --vary liquid.density=1:2:3", 3, &["--set"]);
    refused("sweep nowhere.toml --vary liquid.density=1,2g/cm^3", 4, &["nowhere.toml"]);
    refused(
        "sweep plate.toml --vary liquid.density=1:2g/cm^3 --find angle",
        2,
        &["no check `angle`", "contact_angle.plate"],
    );
    refused(
        "sweep plate.toml --vary liquid.density=1:2:3g/cm^3 --find contact_angle",
        2,
        &["not a range A:B"],
    );
    refused("sweep plate.toml --vary a=1:2 --vary b=1:2 --find contact_angle", 2, &["along one parameter"]);
    refused("sweep plate.toml --vary liquid.density=1:2:3g/cm^3 --tolerance 0.1", 2, &["--find"]);
    refused("sweep plate.toml --vary liquid.density=1:2:3g/cm^3 --case 3", 2, &["no case 3"]);
    refused("sweep plate.toml --vary liquid.density=1:2:3g/cm^3 --case 1 --collect", 2, &["--collect"]);
    // A case that fails is told, and the others go on.
    std::fs::write(place.path("fall.toml"), FALL).unwrap();
    std::fs::create_dir(place.path("broken")).unwrap();
    std::fs::write(place.path("broken/case_0000"), "in the way").unwrap();
    let said = words(&place.expect("sweep fall.toml --vary liquid.density=1,2g/cm^3 --out broken", 4));
    assert!(said.contains("FAILED with exit status 4, see broken/case_0000.log"), "{said}");
    assert!(read(&place.path("broken/case_0000.log")).contains("case_0000"));
    assert_eq!(column(&table(&place.path("broken/sweep.csv")), "state"), ["not started", "finished"]);
}
