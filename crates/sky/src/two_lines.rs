//! Two-line elements. Each line has 69 columns, in which every number has fixed columns; a blank
//! stands for zero. In satellite numbers from 100 000 on, a letter replaces the leading digits
//! (Alpha-5).

use crate::mean_elements::MeanElements;
use thiserror::Error;

/// Number of columns of a line.
const COLUMNS: usize = 69;
/// Columns of each line that must be blank, counted from 1.
const BLANK: [&[usize]; 2] = [&[2, 9, 18, 33, 44, 53, 62, 64], &[2, 8, 17, 26, 34, 43, 52]];
/// Two-digit years below this number belong to the 21st century, all others to the 20th.
const CENTURY: u32 = 57;
/// Ephemeris type of elements for SGP4-XP, an extension of SGP4 whose formulas are not public.
const EXTENDED: u8 = b'4';

/// Error in two-line elements.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum TwoLinesError {
    /// The line does not have 69 columns.
    #[error("line {line} has {found} characters instead of 69")]
    Length {
        /// Number of the line, 1 or 2.
        line: usize,
        /// Number of characters of the line.
        found: usize,
    },
    /// The first character of the line is not the number of the line.
    #[error("line {line} begins with `{found}`, not with {line}")]
    Number {
        /// Number of the line, 1 or 2.
        line: usize,
        /// First character of the line.
        found: char,
    },
    /// The last digit of the line is not the checksum of the line.
    #[error("line {line}, column 69: the checksum is {found}, but its digits give {sum}")]
    Checksum {
        /// Number of the line, 1 or 2.
        line: usize,
        /// Last character of the line.
        found: char,
        /// Checksum of the line.
        sum: u32,
    },
    /// The two lines have the numbers of different satellites, which are given.
    #[error("columns 3 to 7: line 1 names satellite {0}, but line 2 names {1}")]
    Satellites(String, String),
    /// The contents of some columns of a line are invalid.
    #[error("line {line}, column{}: expected {what}, found `{found}`", columns(*.from, *.to))]
    Field {
        /// Number of the line, 1 or 2.
        line: usize,
        /// First of these columns, counted from 1.
        from: usize,
        /// Last of these columns, counted from 1.
        to: usize,
        /// Description of the valid contents.
        what: &'static str,
        /// Contents of the columns in the line.
        found: String,
    },
    /// The elements are for SGP4-XP, which is not supported.
    #[error("line 1, column 63: ephemeris type 4 (SGP4-XP) is not supported")]
    Extended,
}

fn columns(from: usize, to: usize) -> String {
    if from == to { format!(" {from}") } else { format!("s {from} to {to}") }
}

/// A line of 69 ASCII characters with a valid checksum.
struct Line<'t> {
    number: usize,
    text: &'t str,
}

impl<'t> Line<'t> {
    fn of(number: usize, text: &'t str) -> Result<Self, TwoLinesError> {
        let text = text.trim_end();
        if let Some((at, sign)) =
            text.char_indices().find(|(_, sign)| !sign.is_ascii_graphic() && *sign != ' ')
        {
            let column = text[..at].chars().count() + 1;
            let (what, found) = ("a character of two-line elements", sign.escape_default().to_string());
            return Err(TwoLinesError::Field { line: number, from: column, to: column, what, found });
        }
        if text.len() != COLUMNS {
            return Err(TwoLinesError::Length { line: number, found: text.len() });
        }
        let line = Self { number, text };
        let first = text.as_bytes()[0];
        if usize::from(first.wrapping_sub(b'0')) != number {
            return Err(TwoLinesError::Number { line: number, found: char::from(first) });
        }
        for column in BLANK[number - 1] {
            if line.columns(*column, *column) != " " {
                return line.wrong(*column, *column, "a blank");
            }
        }
        // In the checksum, a minus sign counts as 1, and all other characters except digits as 0.
        let digit = |sign: char| if sign == '-' { 1 } else { sign.to_digit(10).unwrap_or(0) };
        let sum = text[..COLUMNS - 1].chars().map(digit).sum::<u32>() % 10;
        let found = char::from(text.as_bytes()[COLUMNS - 1]);
        if found.to_digit(10) == Some(sum) {
            Ok(line)
        } else {
            Err(TwoLinesError::Checksum { line: number, found, sum })
        }
    }

    /// Returns the contents of the columns `from` to `to`, both included and counted from 1.
    fn columns(&self, from: usize, to: usize) -> &'t str {
        &self.text[from - 1..to]
    }

    fn wrong<T>(&self, from: usize, to: usize, what: &'static str) -> Result<T, TwoLinesError> {
        let found = self.columns(from, to).trim().into();
        Err(TwoLinesError::Field { line: self.number, from, to, what, found })
    }

    /// Parses a number with a decimal point. Blanks within the number and after it stand for zeros,
    /// and a blank field is zero.
    fn number(&self, from: usize, to: usize) -> Result<f64, TwoLinesError> {
        let text = self.columns(from, to).trim_start().replace(' ', "0");
        let numeric = text.bytes().all(|sign| sign.is_ascii_digit() || b"+-.".contains(&sign));
        match text.parse::<f64>() {
            _ if text.is_empty() => Ok(0.0),
            Ok(value) if numeric => Ok(value),
            _ => self.wrong(from, to, "a number"),
        }
    }

    /// Parses the decimals of a number whose decimal point is not written.
    fn fraction(&self, from: usize, to: usize) -> Result<f64, TwoLinesError> {
        let digits = self.columns(from, to).replace(' ', "0");
        if !digits.bytes().all(|digit| digit.is_ascii_digit()) {
            return self.wrong(from, to, "a row of digits");
        }
        Ok(format!("0.{digits}").parse().unwrap_or(0.0))
    }

    /// Parses a number that consists of a sign, decimals whose decimal point is not written, and a
    /// signed exponent of ten.
    fn power(&self, from: usize, to: usize) -> Result<f64, TwoLinesError> {
        let sign = |column: usize| match self.columns(column, column) {
            "-" => Ok(-1),
            "+" | " " => Ok(1),
            // Some programs write a zero instead of the sign.
            "0" => Ok(1),
            _ => self.wrong(column, column, "a sign"),
        };
        // Some programs write the decimal point.
        let whole = self.columns(from, to).trim();
        if whole.contains('.') {
            return self.number(from, to);
        }
        let size = self.fraction(from + 1, to - 2)?;
        let exponent = match self.columns(to, to) {
            " " => 0,
            digit => match digit.parse::<i32>() {
                Ok(digit) => digit,
                Err(_) => return self.wrong(to, to, "a digit"),
            },
        };
        Ok(f64::from(sign(from)?) * size * 10_f64.powi(sign(to - 1)? * exponent))
    }

    /// Returns the number of the satellite, in which the first character may be a letter.
    fn satellite(&self) -> Result<String, TwoLinesError> {
        let text = self.columns(3, 7).trim();
        let (first, rest) = text.split_at(text.len().min(1));
        let letter = first.bytes().all(|sign| sign.is_ascii_uppercase() && !b"IO".contains(&sign));
        let known = if letter { text.len() == 5 } else { first.bytes().all(|sign| sign.is_ascii_digit()) };
        if !known || !rest.bytes().all(|sign| sign.is_ascii_digit()) {
            return self.wrong(
                3,
                7,
                "a satellite number; from 100000 on its first digit is a letter other than I and O",
            );
        }
        Ok(text.trim_start_matches('0').into())
    }
}

/// Parses two-line elements.
pub(crate) fn read(lines: [&str; 2]) -> Result<MeanElements, TwoLinesError> {
    let [first, second] = [Line::of(1, lines[0])?, Line::of(2, lines[1])?];
    let [one, two] = [first.satellite()?, second.satellite()?];
    if one != two {
        return Err(TwoLinesError::Satellites(one, two));
    }
    if !"UCS ".contains(first.columns(8, 8)) {
        return first.wrong(8, 8, "a classification, U, C or S");
    }
    match first.columns(63, 63).as_bytes()[0] {
        EXTENDED => return Err(TwoLinesError::Extended),
        b' ' | b'0'..=b'9' => {}
        _ => return first.wrong(63, 63, "a type of ephemeris"),
    }
    first.number(34, 43)?;
    first.power(45, 52)?;
    let year = match first.columns(19, 20).replace(' ', "0").parse::<u32>() {
        Ok(year) if year < CENTURY => 2000 + year,
        Ok(year) => 1900 + year,
        Err(_) => return first.wrong(19, 20, "a year"),
    };
    let day = first.number(21, 32)?;
    let leap = year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400));
    if !(1.0..if leap { 367.0 } else { 366.0 }).contains(&day) {
        return first.wrong(21, 32, "a day of that year");
    }
    let inclination_deg = second.number(9, 16)?;
    if !(0.0..=180.0).contains(&inclination_deg) {
        return second.wrong(9, 16, "an inclination from 0 to 180 deg");
    }
    let mean_motion = second.number(53, 63)?;
    if mean_motion <= 0.0 {
        return second.wrong(53, 63, "a mean motion above 0");
    }
    Ok(MeanElements {
        year: year as i32,
        day_of_year: day as u32,
        nanoseconds_of_day: (day.fract() * 86_400e9).round() as u64,
        mean_motion,
        eccentricity: second.fraction(27, 33)?,
        inclination_deg,
        raan_deg: second.number(18, 25)?,
        argument_of_perigee_deg: second.number(35, 42)?,
        mean_anomaly_deg: second.number(44, 51)?,
        drag: first.power(54, 61)?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const LINES: [&str; 2] = [
        "1 99991U 20001A   26324.50000000  .00000100  00000-0  20000-4 0  9999",
        "2 99991  97.8000 200.1000 0011999  90.2000 270.1000 14.90000000    11",
    ];

    /// Returns the line with the text `piece` at the column `column`, and with the checksum that
    /// belongs to the changed line.
    fn with(line: &str, column: usize, piece: &str) -> String {
        let mut text = format!("{}{piece}{}", &line[..column - 1], &line[column - 1 + piece.len()..]);
        let digit = |sign: char| if sign == '-' { 1 } else { sign.to_digit(10).unwrap_or(0) };
        let sum = text[..68].chars().map(digit).sum::<u32>() % 10;
        text.replace_range(68.., &sum.to_string());
        text
    }

    #[test]
    fn numbers_stand_in_their_columns() {
        let found = read(LINES).unwrap();
        assert_eq!(
            (found.year, found.day_of_year, found.nanoseconds_of_day),
            (2026, 324, 43_200_000_000_000)
        );
        assert_eq!((found.eccentricity, found.drag), (0.001_199_9, 2e-5));
        assert_eq!((found.mean_motion, found.inclination_deg), (14.9, 97.8));
    }

    #[test]
    fn blanks_are_zeros() {
        let one = with(&with(LINES[0], 63, " "), 45, "        ");
        let two = with(&with(LINES[1], 27, "  12   "), 35, " 90.2   ");
        let found = read([&one, &two]).unwrap();
        assert_eq!((found.eccentricity, found.argument_of_perigee_deg), (0.0012, 90.2));
    }

    #[test]
    fn letters_count_on_from_one_hundred_thousand() {
        let lines = [with(LINES[0], 3, "B1234"), with(LINES[1], 3, "B1234")];
        assert!(read([&lines[0], &lines[1]]).is_ok());
        for number in ["I1234", "O1234", "b1234", "B123 ", "1B234"] {
            let lines = [with(LINES[0], 3, number), with(LINES[1], 3, number)];
            let said = read([&lines[0], &lines[1]]).unwrap_err().to_string();
            assert!(said.starts_with("line 1, columns 3 to 7"), "{number}: {said}");
        }
    }

    #[test]
    fn a_refusal_names_the_column() {
        let collapsed = "1 99991U 20001A 26324.50000000 .00000100 00000-0 20000-4 0 9999";
        let [one, two] = LINES;
        for (lines, told) in [
            ([collapsed.to_string(), two.into()], "line 1 has 63 characters instead of 69"),
            (
                [format!("{}3", &one[..68]), two.into()],
                "line 1, column 69: the checksum is 3, but its digits give 9",
            ),
            ([two.into(), one.into()], "line 1 begins with `2`"),
            ([one.into(), with(two, 3, "99992")], "line 1 names satellite 99991, but line 2 names 99992"),
            ([with(one, 33, "5"), two.into()], "line 1, column 33: expected a blank, found `5`"),
            ([with(one, 63, "4"), two.into()], "SGP4-XP"),
            ([with(one, 63, "x"), two.into()], "line 1, column 63: expected a type"),
            (
                [with(one, 21, "367.00000000"), two.into()],
                "line 1, columns 21 to 32: expected a day of that year",
            ),
            ([with(one, 59, "x"), two.into()], "line 1, columns 55 to 59: expected a row of digits"),
            ([one.into(), with(two, 9, "197.8000")], "line 2, columns 9 to 16: expected an inclination"),
            ([one.into(), with(two, 27, "-011999")], "line 2, columns 27 to 33: expected a row of digits"),
            (
                [one.into(), with(two, 44, "270,1000")],
                "line 2, columns 44 to 51: expected a number, found `270,1000`",
            ),
            ([one.into(), with(two, 53, " 0.00000000")], "line 2, columns 53 to 63: expected a mean motion"),
            ([one.replace("  9999", " \u{a0}9999"), two.into()], "line 1, column 65: expected a character"),
        ] {
            let said = read([&lines[0], &lines[1]]).unwrap_err().to_string();
            assert!(said.contains(told), "{told}: {said}");
        }
    }
}
