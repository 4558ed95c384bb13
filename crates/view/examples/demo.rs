//! Made-up runs to look at: `demo sample DIR` writes three output folders, `demo render DIR [SIZE [FRAME [STYLE]]]`
//! and `demo page DIR` show one.

#[path = "../tests/all/common/mod.rs"]
mod common;

use std::path::Path;
use std::time::Instant;

use meniscus_view::{ImageSize, PageOptions, RenderOptions, Style, make_page, render};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let start = Instant::now();
    match words.as_slice() {
        ["sample", dir] => {
            let dir = Path::new(dir);
            common::write(&dir.join("ball"), common::Sample::Ball, 40);
            common::write(&dir.join("drop"), common::Sample::Drop, 40);
            common::write(&dir.join("flat"), common::Sample::Flat, 40);
        }
        ["render", dir, rest @ ..] => {
            let mut options = RenderOptions::default();
            if let Some((w, h)) = rest.first().and_then(|s| s.split_once('x')) {
                options.size = ImageSize { width: w.parse()?, height: h.parse()? };
            }
            if let Some(frame) = rest.get(1).filter(|f| **f != "all") {
                let frame = frame.parse()?;
                options.frames = Some(frame..=frame);
            }
            if rest.get(2) == Some(&"matte") {
                options.style = Some(Style::Matte);
            }
            let made =
                render(Path::new(dir), &options, |done, all| println!("{done}/{all} {:?}", start.elapsed()))?;
            println!("{:?} {:?}", made.film, made.no_film);
        }
        ["page", dir] => println!("{:?}", make_page(Path::new(dir), &PageOptions::default())?),
        _ => println!("demo sample DIR | demo render DIR [SIZE [FRAME [STYLE]]] | demo page DIR"),
    }
    println!("{:?}", start.elapsed());
    Ok(())
}
