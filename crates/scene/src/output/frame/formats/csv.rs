//! The contact line of each frame as a table.

use crate::output::frame::{Frame, FrameWriter};
use crate::output::{FileError, Folder, atomic_file};
use std::io::Write;
use std::path::PathBuf;

/// Writes `contact_line_NNNN.csv` where there is a contact line: one row for each vertex with the time, its position and all
/// attributes. The first row has their names with units in parentheses; numbers have all their digits.
#[derive(Clone, Copy, Debug)]
pub struct CsvWriter;

impl FrameWriter for CsvWriter {
    fn write(&self, folder: &Folder, number: u64, frame: &Frame) -> Result<PathBuf, FileError> {
        let Some(line) = &frame.contact_line else { return Ok(folder.frames()) };
        let path = folder.frame_file("contact_line", number, "csv");
        atomic_file::write_atomically(&path, |file| {
            let unit = frame.unit_text("m");
            write!(file, "time (s),x ({unit}),y ({unit}),z ({unit})")?;
            for attribute in &line.attributes {
                match &*attribute.unit {
                    "1" => write!(file, ",{}", attribute.name)?,
                    unit => write!(file, ",{} ({unit})", attribute.name)?,
                }
            }
            writeln!(file)?;
            for (vertex, [x, y, z]) in line.positions.iter().enumerate() {
                write!(file, "{:?},{x:?},{y:?},{z:?}", frame.time)?;
                line.attributes.iter().try_for_each(|a| match &*a.name {
                    "solid" => write!(file, ",{}", a.values[vertex]),
                    _ => write!(file, ",{:?}", a.values[vertex]),
                })?;
                writeln!(file)?;
            }
            Ok(())
        })?;
        Ok(path)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::frame::formats::tests::{Place, empty_frame, full_frame};

    #[test]
    fn the_table_has_units_and_all_digits() {
        let place = Place::new("csv");
        CsvWriter.write(&place.0, 3, &full_frame()).unwrap();
        CsvWriter.write(&place.0, 4, &empty_frame()).unwrap();
        assert_eq!(place.files(), ["contact_line_0003.csv"]);
        let text = place.text("contact_line_0003.csv");
        let rows: Vec<&str> = text.lines().collect();
        assert_eq!(rows[0], "time (s),x (m),y (m),z (m),angle (deg),speed (m/s),solid");
        assert_eq!(rows[1], "0.30000000000000004,0.1,0.0,0.0,89.5,-1e-9,0");
        let y: f64 = rows[3].split(',').nth(2).unwrap().parse().unwrap();
        assert_eq!((rows.len(), y), (4, 1.0 / 3.0));
    }
}
