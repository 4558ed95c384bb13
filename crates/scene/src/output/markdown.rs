//! Parts of Markdown pages: text on one line, cells and rows of tables.

/// A text without line breaks and repeated blanks.
pub fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// A text as a cell of a table: on one line, with `|`, which would end the cell, escaped.
pub fn cell(text: &str) -> String {
    one_line(text).replace('|', "\\|")
}

/// A row of a table, with the line break at its end.
pub fn row<S: AsRef<str>>(cells: &[S]) -> String {
    let cells: Vec<String> = cells.iter().map(|text| cell(text.as_ref())).collect();
    format!("| {} |\n", cells.join(" | "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_stay_within_their_row() {
        assert_eq!(cell("max|u|\n  at the end"), r"max\|u\| at the end");
        assert_eq!(cell(""), "");
        assert_eq!(row(&["a|b", "2"]), "| a\\|b | 2 |\n");
        assert_eq!(row(&[String::from("one")]), "| one |\n");
    }
}
