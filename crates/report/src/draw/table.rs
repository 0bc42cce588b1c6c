//! Tables of text.

/// Formats rows of cells as lines. A column is as wide as its widest cell, and two spaces separate
/// the columns. The columns with an index in `left` are left-aligned, all others right-aligned. A
/// row with fewer cells than the first row is a remark: its last cell extends to the end of the
/// line.
pub fn table(rows: &[Vec<String>], left: &[usize]) -> Vec<String> {
    let columns = rows.first().map_or(0, Vec::len);
    let is_cell = |row: &[String], column: usize| row.len() == columns || column + 1 < row.len();
    let width = |column: usize| {
        let cells = rows.iter().filter(|row| is_cell(row, column)).map(|row| row[column].chars().count());
        cells.max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let line = |row: &Vec<String>| {
        let cell = |(column, cell): (usize, &String)| match widths[column] {
            _ if !is_cell(row, column) => cell.clone(),
            width if left.contains(&column) => format!("{cell:<width$}"),
            width => format!("{cell:>width$}"),
        };
        row.iter().enumerate().map(cell).collect::<Vec<_>>().join("  ").trim_end().to_string()
    };
    rows.iter().map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_as_wide_as_their_cells() {
        let rows = [vec!["name", "x", "y"], vec!["a", "1.5", "−12"], vec!["b", "fails at the start"]];
        let rows = rows.map(|row| row.into_iter().map(String::from).collect());
        assert_eq!(table(&rows, &[0]), ["name    x    y", "a     1.5  −12", "b     fails at the start"]);
        assert!(table(&[], &[]).is_empty());
    }
}
