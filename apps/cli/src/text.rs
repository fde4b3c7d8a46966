//! Formats numbers and tables as text.

use std::fmt::Write;

/// Formats a number with separators: `1,234,567`.
pub(crate) fn count(number: u64) -> String {
    let digits = number.to_string();
    let mut grouped = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            grouped.push(',');
        }
        grouped.push(digit);
    }
    grouped
}

/// Formats a number with its noun: `1 item`, `2 items`.
pub(crate) fn plural(number: usize, one: &str) -> String {
    format!(
        "{} {one}{}",
        count(number as u64),
        if number == 1 { "" } else { "s" }
    )
}

/// Formats bytes with a decimal unit: `12.3 MB`.
pub(crate) fn bytes(number: u64) -> String {
    const UNITS: [&str; 4] = ["kB", "MB", "GB", "TB"];
    if number < 1000 {
        return plural(number as usize, "byte");
    }
    let mut shown = number as f64 / 1000.0;
    let mut unit = 0;
    while shown >= 999.95 && unit + 1 < UNITS.len() {
        shown /= 1000.0;
        unit += 1;
    }
    format!("{shown:.1} {}", UNITS[unit])
}

/// Formats milliseconds with about three significant digits.
pub(crate) fn ms(milliseconds: f64) -> String {
    match milliseconds {
        m if m < 10.0 => format!("{m:.2}"),
        m if m < 100.0 => format!("{m:.1}"),
        m => format!("{m:.0}"),
    }
}

/// Formats a number with at most four significant digits.
pub(crate) fn short(number: f64) -> String {
    let whole_digits = if number == 0.0 {
        1
    } else {
        number.abs().log10().floor() as i32 + 1
    };
    let decimals = (4 - whole_digits).clamp(0, 12) as usize;
    let text = format!("{number:.decimals$}");
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

/// Formats a share, 0 to 1, as `97.3 %`. Rounds down, so that only all is 100 %.
pub(crate) fn percent(share: f64) -> String {
    let tenths = (1000.0 * share).floor() / 10.0;
    format!("{} %", short(tenths))
}

/// Formats a point: `1.2, 3.4, 5.6`.
pub(crate) fn point(point: [f32; 3]) -> String {
    point.map(|value| short(value.into())).join(", ")
}

/// Formats a table with a header; the first column is left-aligned, the others right-aligned.
pub(crate) fn table(header: &[&str], rows: &[Vec<String>]) -> String {
    let width = |column: usize| {
        let cells = rows.iter().map(|row| row[column].chars().count());
        cells.chain([header[column].chars().count()]).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..header.len()).map(width).collect();
    let header: Vec<String> = header.iter().map(|&cell| cell.to_owned()).collect();
    let mut text = String::new();
    for row in std::iter::once(&header).chain(rows) {
        let mut line = String::new();
        for (column, (cell, &width)) in row.iter().zip(&widths).enumerate() {
            // Writing to a String cannot fail.
            let _ = if column == 0 {
                write!(line, "  {cell:<width$}")
            } else {
                write!(line, "  {cell:>width$}")
            };
        }
        text.push_str(line.trim_end());
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_well() {
        assert_eq!(
            [0, 999, 1000, 1_234_567].map(count),
            ["0", "999", "1,000", "1,234,567"]
        );
        assert_eq!(
            [1, 999, 1000, 999_999, 2_500_000_000].map(bytes),
            ["1 byte", "999 bytes", "1.0 kB", "1.0 MB", "2.5 GB"]
        );
        assert_eq!(
            [0.0, 9.876, 43.21, 1234.5].map(ms),
            ["0.00", "9.88", "43.2", "1234"]
        );
    }

    #[test]
    fn numbers_have_four_significant_digits_and_no_zeros_behind() {
        assert_eq!(
            [0.0, 1.0, 12.345678, -0.000123456, 12_345.6, 99.999].map(short),
            ["0", "1", "12.35", "-0.0001235", "12346", "100"]
        );
        assert_eq!(point([1.0, -2.34567, 1234.5]), "1, -2.346, 1234");
    }

    #[test]
    fn columns_stand_under_their_headers() {
        let rows = [
            vec!["z-buffer".to_owned(), "7".to_owned()],
            vec!["b".to_owned(), "1,000".to_owned()],
        ];
        assert_eq!(
            table(&["method", "n"], &rows),
            "  method        n\n  z-buffer      7\n  b         1,000\n"
        );
    }
}
