//! `meniscus schema`, `info` and `completions`.

use super::print;
use crate::args::Cli;
use crate::failure::Result;
use clap::CommandFactory;
use serde_json::json;

/// Prints the JSON Schema of scene files, or the grammar as Markdown.
pub fn schema(markdown: bool) -> Result {
    let schema = meniscus_scene::schema::json_schema() + "\n";
    print(&if markdown { meniscus_scene::schema::markdown() } else { schema })?;
    Ok(0)
}

/// Prints version, build and machine.
pub fn info(as_json: bool) -> Result {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let memory = meniscus_scene::estimate::memory::machine_memory();
    let build = if cfg!(debug_assertions) { "debug" } else { "release" };
    let vectors = if cfg!(target_feature = "avx512f") {
        "AVX-512"
    } else if cfg!(target_feature = "avx2") {
        "AVX2"
    } else {
        "baseline"
    };
    if as_json {
        let value = json!({
            "version": env!("CARGO_PKG_VERSION"), "build": build, "vectors": vectors, "os": std::env::consts::OS,
            "arch": std::env::consts::ARCH, "threads": threads, "memory_bytes": memory, "devices": [],
            "scene_format": 1,
        });
        print(&format!("{value:#}\n"))?;
        return Ok(0);
    }
    let memory = memory.map_or("unknown".to_string(), |m| format!("{:.1} GB", m as f64 * 1e-9));
    print(&format!(
        "meniscus {} ({build}, {} {}, {vectors})\nscene format 1\n{threads} threads, {memory} memory\n\
         devices: CPU only in this version\n",
        env!("CARGO_PKG_VERSION"),
        std::env::consts::OS,
        std::env::consts::ARCH,
    ))?;
    Ok(0)
}

/// Prints completions for a shell.
pub fn completions(shell: clap_complete::Shell) -> Result {
    let mut text = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), "meniscus", &mut text);
    print(&String::from_utf8_lossy(&text))?;
    Ok(0)
}
