//! SVG elements of which charts consist.

use std::fmt::Write;

/// Font families of all texts.
const FONT: &str = "Helvetica, Arial, 'DejaVu Sans', sans-serif";
/// Font size of texts \[px\].
pub(super) const FONT_SIZE: f64 = 13.0;
/// Font size of superscripts \[px\]. It is not given in percent, because some viewers relate
/// percentages to the page.
const RAISED_SIZE: f64 = 9.75;

/// The width and height of charts and sky maps \[px\].
pub(super) const SIZE: (f64, f64) = (800.0, 480.0);

/// Colour of texts and frames.
pub(super) const INK: &str = "#222222";
/// Colour of faint text.
pub(super) const FAINT: &str = "#666666";
/// Colour of grid lines.
pub(super) const GRID: &str = "#dddddd";

/// An SVG document that is being written.
pub(super) struct Svg {
    text: String,
}

/// Part of a text that is placed at a given point: its start, middle or end.
#[derive(Clone, Copy)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

impl Svg {
    pub fn new(width: f64, height: f64) -> Self {
        let mut text = String::new();
        let _ = write!(
            text,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {width} {height}\" font-family=\"{FONT}\" font-size=\"{FONT_SIZE}\">\n\
             <rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n"
        );
        Self { text }
    }

    pub fn end(mut self) -> String {
        self.text.push_str("</svg>\n");
        self.text
    }

    /// Adds the text of an SVG element without escaping it.
    pub fn raw(&mut self, element: &str) {
        self.text.push_str(element);
        self.text.push('\n');
    }

    pub fn line(&mut self, a: (f64, f64), b: (f64, f64), style: &str) {
        let ([x1, y1], [x2, y2]) = ([a.0, a.1].map(number), [b.0, b.1].map(number));
        self.raw(&format!("<line x1=\"{x1}\" y1=\"{y1}\" x2=\"{x2}\" y2=\"{y2}\" {style}/>"));
    }

    pub fn circle(&mut self, center: (f64, f64), radius: f64, style: &str) {
        let [x, y, r] = [center.0, center.1, radius].map(number);
        self.raw(&format!("<circle cx=\"{x}\" cy=\"{y}\" r=\"{r}\" {style}/>"));
    }

    /// Adds a polyline, or a polygon if it is closed.
    pub fn path(&mut self, points: &[(f64, f64)], closed: bool, style: &str) {
        let name = if closed { "polygon" } else { "polyline" };
        let list: Vec<String> =
            points.iter().map(|(x, y)| format!("{},{}", number(*x), number(*y))).collect();
        self.raw(&format!("<{name} points=\"{}\" {style}/>", list.join(" ")));
    }

    /// Fills the area between several closed curves, according to the fill rule in `style`.
    pub fn area(&mut self, curves: &[&[(f64, f64)]], style: &str) {
        let mut path = String::new();
        for curve in curves {
            for (index, (x, y)) in curve.iter().enumerate() {
                let command = if index == 0 { 'M' } else { 'L' };
                let _ = write!(path, "{command}{} {}", number(*x), number(*y));
            }
            path.push('Z');
        }
        self.raw(&format!("<path d=\"{path}\" {style}/>"));
    }

    /// Adds a text. A part in `^{…}` becomes a superscript.
    pub fn text(&mut self, at: (f64, f64), anchor: Anchor, style: &str, text: &str) {
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let [x, y] = [at.0, at.1].map(number);
        self.raw(&format!(
            "<text x=\"{x}\" y=\"{y}\" text-anchor=\"{anchor}\" {style}>{}</text>",
            rich(text)
        ));
    }
}

/// Escapes a text, and converts each part in `^{…}` to a superscript.
fn rich(text: &str) -> String {
    let mut out = String::new();
    let mut rest = text;
    while let Some(at) = rest.find("^{") {
        let (before, after) = (&rest[..at], &rest[at + 2..]);
        let Some(end) = after.find('}') else { break };
        let raised = escape(&after[..end]);
        // The second shift returns to the baseline for the text that follows.
        let _ =
            write!(out, "{}<tspan dy=\"-5\" font-size=\"{RAISED_SIZE}\">{raised}</tspan>", escape(before));
        rest = &after[end + 1..];
        if !rest.is_empty() {
            let first = rest.chars().next().map_or(0, char::len_utf8);
            let _ = write!(out, "<tspan dy=\"5\">{}</tspan>", escape(&rest[..first]));
            rest = &rest[first..];
        }
    }
    out + &escape(rest)
}

/// Escapes a text for XML and HTML, between tags and in quoted attributes.
pub fn escape(text: &str) -> String {
    let mut out = String::new();
    for character in text.chars() {
        match character {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            // Control characters are not allowed in XML files, even if they are escaped.
            c if c.is_control() => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}

/// Breaks a name at spaces into lines of at most `room` characters. A word that is longer is
/// truncated.
pub(super) fn broken(name: &str, room: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in name.split(' ').filter(|word| !word.is_empty()) {
        let word = shortened(word, room);
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= room => {
                line.push(' ');
                line.push_str(&word);
            }
            _ => lines.push(word),
        }
    }
    if lines.is_empty() { vec![String::new()] } else { lines }
}

/// Truncates a name to at most `room` characters.
pub(super) fn shortened(name: &str, room: usize) -> String {
    if name.chars().count() <= room {
        return name.into();
    }
    name.chars().take(room - 1).chain(['…']).collect()
}

/// Formats a coordinate to a hundredth of a pixel.
fn number(value: f64) -> String {
    let text = format!("{value:.2}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".into() } else { text.into() }
}
