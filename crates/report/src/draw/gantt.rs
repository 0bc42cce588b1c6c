//! Timeline charts, with one row for each thruster or other object and a bar for each time interval
//! in which the object is on. Long intervals in which all objects are off are omitted from the time
//! axis.

use super::axis::{Axis, Laid};
use super::colour;
use super::svg::{Anchor, FAINT, FONT_SIZE, GRID, INK, SIZE, Svg, shortened};
use slewkit::numerics::figures::significant;

/// A timeline chart with one row of bars for each object.
#[derive(Clone, Debug, PartialEq)]
pub struct Gantt {
    /// Title of the chart.
    pub title: String,
    /// The subtitle, one line below the title.
    pub subtitle: String,
    /// End of the time axis, which begins at 0 \[s\].
    pub end: f64,
    /// Rows of the chart. Each has the name of an object, and the start and the end of every
    /// interval in which the object is on \[s\], in chronological order.
    pub rows: Vec<(String, Vec<[f64; 2]>)>,
}

/// Left edge of the rows \[px\]; long names move it to the right.
const LEFT: f64 = 118.0;
/// Right edge of the rows \[px\].
const RIGHT: f64 = 776.0;
/// Upper edge of the rows of a chart with a title \[px\].
const TOP: f64 = 64.0;
const UNTITLED: f64 = 12.0;
/// Lower edge of the area for rows \[px\].
const BOTTOM: f64 = 418.0;
/// Largest height of a row \[px\].
const ROW: f64 = 34.0;
/// Fraction of the height of a row that a bar fills.
const BAR: f64 = 0.62;
/// The smallest width of a bar [px].
const NARROW: f64 = 1.6;
/// Width of a character of a name \[px\].
const LETTER: f64 = 7.0;
/// Distance between a name and its row \[px\].
const BESIDE_ROWS: f64 = 8.0;
/// Largest number of characters of a name.
const LONGEST: usize = 28;
/// Width of the gap in place of an omitted interval \[px\].
const BREAK: f64 = 26.0;
/// Factor in the first of two conditions for omitting an interval without bars: it must be longer
/// than this factor times the total time with bars.
const LONG: f64 = 0.4;
/// Fraction of the whole duration that an omitted interval must exceed, which is the second
/// condition.
const NOTED: f64 = 0.05;
/// Length of the part of an omitted interval that is shown at each of its ends, as a fraction of
/// the total time with bars. It must be less than half of [`LONG`].
const BESIDE: f64 = 0.15;
/// Smallest width of an interval that is shown \[px\].
const LEAST: f64 = 24.0;

/// An interval of the time axis \[s\] with its position in the drawing.
struct Piece {
    from: f64,
    to: f64,
    /// Pixel of the left end of the interval.
    left: f64,
    right: f64,
    left_out: bool,
}

impl Gantt {
    /// Returns the chart as the text of an SVG file.
    pub fn svg(&self) -> String {
        let mut svg = Svg::new(SIZE.0, self.bottom() + 62.0);
        self.draw(&mut svg);
        svg.end()
    }

    /// Returns the lower edge of the rows [px].
    fn bottom(&self) -> f64 {
        self.top() + (self.rows.len().max(1) as f64 * ROW).min(BOTTOM - TOP)
    }

    /// Returns the left edge of the rows [px], which leaves room for their names.
    fn left(&self) -> f64 {
        let longest = self.rows.iter().map(|(name, _)| name.chars().count().min(LONGEST)).max();
        LEFT.max(2.0 * BESIDE_ROWS + LETTER * longest.unwrap_or(0) as f64)
    }

    /// Returns the upper edge of the rows [px].
    fn top(&self) -> f64 {
        if self.title.is_empty() && self.subtitle.is_empty() { UNTITLED } else { TOP }
    }

    /// Returns the time intervals in which at least one object is on, in chronological order.
    fn busy(&self) -> Vec<[f64; 2]> {
        let mut all: Vec<[f64; 2]> = self.rows.iter().flat_map(|(_, bars)| bars.iter().copied()).collect();
        all.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let mut joined: Vec<[f64; 2]> = Vec::new();
        for bar in all {
            match joined.last_mut() {
                Some(last) if bar[0] <= last[1] => last[1] = last[1].max(bar[1]),
                _ => joined.push(bar),
            }
        }
        joined
    }

    /// Divides the time axis into intervals that are shown and intervals that are omitted, and
    /// places them.
    fn pieces(&self) -> Vec<Piece> {
        let busy = self.busy();
        let on: f64 = busy.iter().map(|[from, to]| to - from).sum();
        let long = (LONG * on).max(NOTED * self.end);
        let mut gaps: Vec<[f64; 2]> = busy.windows(2).map(|pair| [pair[0][1], pair[1][0]]).collect();
        gaps.extend(busy.first().map(|first| [0.0, first[0]]));
        gaps.extend(busy.last().map(|last| [last[1], self.end]));
        gaps.retain(|[from, to]| to - from > long);
        gaps.sort_by(|a, b| a[0].total_cmp(&b[0]));
        // A short part at each end of an omitted interval is shown next to the bars.
        let beside = BESIDE * on;
        let piece = |from: f64, to: f64, left_out: bool| Piece { from, to, left: 0.0, right: 0.0, left_out };
        let mut pieces = Vec::new();
        let mut at = 0.0;
        for [from, to] in gaps {
            let from = if from > 0.0 { from + beside } else { from };
            let to = if to < self.end { to - beside } else { to };
            if from > at {
                pieces.push(piece(at, from, false));
            }
            pieces.push(piece(from, to, true));
            at = to;
        }
        if at < self.end {
            pieces.push(piece(at, self.end, false));
        }
        laid_out(&mut pieces, self.left());
        pieces
    }

    pub(super) fn draw(&self, svg: &mut Svg) {
        let bold = format!("font-size=\"16\" font-weight=\"bold\" fill=\"{INK}\"");
        let left_edge = self.left();
        svg.text((left_edge, 26.0), Anchor::Start, &bold, &self.title);
        svg.text((left_edge, 47.0), Anchor::Start, &format!("fill=\"{FAINT}\""), &self.subtitle);
        let (pieces, top, bottom) = (self.pieces(), self.top(), self.bottom());
        let row = (bottom - top) / self.rows.len().max(1) as f64;
        let (grid, ink) = (format!("stroke=\"{GRID}\""), format!("fill=\"{INK}\""));
        for piece in pieces.iter().filter(|piece| !piece.left_out) {
            let axis = Axis { limits: Some((piece.from, piece.to)), ..Axis::linear("") };
            let laid = Laid::new(&axis, std::iter::empty(), piece.left, piece.right);
            for tick in laid.ticks().into_iter().filter(|tick| (piece.left..=piece.right).contains(&tick.at))
            {
                svg.line((tick.at, top), (tick.at, bottom), &grid);
                if let Some(label) = tick.label {
                    svg.text((tick.at, bottom + 20.0), Anchor::Middle, &ink, &label);
                }
            }
        }
        for (index, (name, bars)) in self.rows.iter().enumerate() {
            let middle = top + (index as f64 + 0.5) * row;
            let at = (left_edge - BESIDE_ROWS, middle + 0.35 * FONT_SIZE);
            svg.text(at, Anchor::End, &ink, &shortened(name, LONGEST));
            svg.line((left_edge, middle + 0.5 * row), (RIGHT, middle + 0.5 * row), &grid);
            for [from, to] in bars {
                let Some((left, right)) = place(&pieces, *from).zip(place(&pieces, *to)) else { continue };
                let width = (right - left).max(NARROW);
                let height = BAR * row;
                let style = format!("fill=\"{}\"", colour(0));
                let corners = [
                    (left, middle - 0.5 * height),
                    (left + width, middle - 0.5 * height),
                    (left + width, middle + 0.5 * height),
                    (left, middle + 0.5 * height),
                ];
                svg.path(&corners, true, &style);
            }
        }
        for piece in pieces.iter().filter(|piece| piece.left_out) {
            let middle = 0.5 * (piece.left + piece.right);
            let corners =
                [(piece.left, top), (piece.right, top), (piece.right, bottom), (piece.left, bottom)];
            svg.path(&corners, true, "fill=\"#f3f4f6\"");
            for (aside, y) in [(-3.0, top), (3.0, top), (-3.0, bottom), (3.0, bottom)] {
                let cut = format!("stroke=\"{INK}\" stroke-width=\"1.2\"");
                svg.line((middle + aside - 3.0, y + 6.0), (middle + aside + 3.0, y - 6.0), &cut);
            }
            let at = (middle, 0.5 * (top + bottom));
            let turned =
                format!("font-size=\"11\" fill=\"{FAINT}\" transform=\"rotate(-90 {} {})\"", at.0, at.1);
            let length = format!("{} s off", significant(piece.to - piece.from, 3));
            svg.text((at.0, at.1 + 4.0), Anchor::Middle, &turned, &length);
        }
        let frame = [(left_edge, top), (RIGHT, top), (RIGHT, bottom), (left_edge, bottom)];
        svg.path(&frame, true, &format!("fill=\"none\" stroke=\"{INK}\""));
        svg.text((0.5 * (left_edge + RIGHT), bottom + 44.0), Anchor::Middle, &ink, "time, s");
    }
}

/// Places the intervals side by side from pixel `left` on. All shown intervals have the same scale,
/// except for intervals that would be narrower than [`LEAST`].
fn laid_out(pieces: &mut [Piece], left: f64) {
    let length = |piece: &Piece| piece.to - piece.from;
    let breaks = pieces.iter().filter(|piece| piece.left_out).count() as f64;
    let (mut room, mut shown) = (RIGHT - left - breaks * BREAK, 0.0);
    shown += pieces.iter().filter(|piece| !piece.left_out).map(length).sum::<f64>();
    let all = room / shown;
    for piece in pieces.iter().filter(|piece| !piece.left_out && all * length(piece) < LEAST) {
        (room, shown) = (room - LEAST, shown - length(piece));
    }
    let mut pixel = left;
    for piece in pieces {
        let width = match piece.left_out {
            true => BREAK,
            false if all * length(piece) < LEAST => LEAST,
            false => room * length(piece) / shown,
        };
        (piece.left, piece.right) = (pixel, pixel + width);
        pixel += width;
    }
}

/// Returns the pixel of a time \[s\]; `None` if the axis does not contain it.
fn place(pieces: &[Piece], time: f64) -> Option<f64> {
    let piece = pieces.iter().find(|piece| time <= piece.to).or(pieces.last())?;
    let part = ((time - piece.from) / (piece.to - piece.from)).clamp(0.0, 1.0);
    Some(piece.left + part * (piece.right - piece.left))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// On a time axis without gaps, pulses of 0.1 s at both ends of a maneuver of 200 s would be a
    /// third of a pixel wide.
    #[test]
    fn short_pulses_are_wide_where_the_coast_between_them_is_long() {
        let rows = vec![("A".into(), vec![[0.0, 0.1]]), ("B".into(), vec![[0.1, 0.2], [199.9, 200.0]])];
        let gantt = Gantt { title: String::new(), subtitle: String::new(), end: 200.0, rows };
        let pieces = gantt.pieces();
        let at = |time: f64| place(&pieces, time).unwrap();
        for [from, to] in [[0.0, 0.1], [0.1, 0.2], [199.9, 200.0]] {
            assert!(at(to) - at(from) > 100.0, "{from} {to}: {} {}", at(from), at(to));
        }
        assert!((at(0.0) - LEFT).abs() < 1e-9 && (at(200.0) - RIGHT).abs() < 1e-9);
        // The pixels of increasing times increase.
        let times: Vec<f64> = (0..=2000).map(|k| at(0.1 * f64::from(k))).collect();
        assert!(times.windows(2).all(|pair| pair[0] <= pair[1]));
        assert!(gantt.svg().contains("s off") && !gantt.svg().contains("NaN"));
    }

    #[test]
    fn an_axis_without_a_long_coast_has_no_break() {
        let rows = vec![("A".into(), vec![[0.0, 1.0], [1.5, 3.0]])];
        let gantt = Gantt { title: String::new(), subtitle: String::new(), end: 3.0, rows };
        assert_eq!(gantt.pieces().len(), 1);
        assert!(!gantt.svg().contains("s off"));
    }
}
