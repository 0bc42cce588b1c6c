//! One self-contained HTML file that shows a plan and loads no other file.
//!
//! Text from a spec is escaped. Every `<` in the data of the script is escaped, so that no text can
//! close the script element. A browser without scripts shows the text and the tables.

use super::body::body;
use super::document::document;
use super::summary::{self, Tone};
use super::tiles::{Tile, tiles};
use super::words::{Table, proved, tables};
use super::{
    CASE_KEYS, COMPARISON_KEYS, INTEGRATOR_KEYS, MOST_POINTS, SEQUENCE_KEYS, Shown, Subject, flight,
    hamiltonian, pictures,
};
use crate::draw::{Gantt, Ground, Map, Picture, escape};
use serde_json::Value;
use slewkit::maneuver::{Problem, Settings, State};
use slewkit::numerics::figures::rounded;
use slewkit::plan::Plan;
use slewkit_files::flown::MarginsRecord;
use slewkit_files::identity::Identity;
use slewkit_files::spec::ClosedLoop;
use std::fmt::Write;

impl Tone {
    fn class(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Bad => "bad",
            Self::Note => "note",
        }
    }

    fn sign(self) -> &'static str {
        match self {
            Self::Good => "✓",
            Self::Bad => "✗",
            Self::Note => "!",
        }
    }
}

/// Texts at the top of a page: the verdict, the summary and the details.
pub(super) struct Words {
    /// Verdict on the plan, such as "solved and verified".
    pub verdict: String,
    /// Tone of the verdict, good or bad, which determines its colour.
    pub tone: Tone,
    /// Lines of the summary, each with a label and a text. A line with an empty label continues the
    /// previous line.
    pub summary: Vec<(String, String)>,
    /// Lines of the details on how the plan was found; the page shows them on request.
    pub details: Vec<(String, String)>,
}

/// The name and version of the program, for the footer of the page.
const GENERATOR: &str = concat!("slewkit ", env!("CARGO_PKG_VERSION"), ", `slew report`");

const STYLE: &str = include_str!("page/style.css");

/// Parts of the script, each of which may use the parts before it.
const SCRIPT: [&str; 6] = [
    include_str!("page/base.js"),
    include_str!("page/chart.js"),
    include_str!("page/sky.js"),
    include_str!("page/body.js"),
    include_str!("page/euler.js"),
    include_str!("page/start.js"),
];

/// The groups of pictures: identifier, heading, and the names of the pictures in the group.
const GROUPS: [(&str, &str, &[&str]); 11] = [
    ("timeline", "Timeline", &SEQUENCE_KEYS),
    ("cases", "Over the cases", &CASE_KEYS),
    ("compared", "Side by side", &COMPARISON_KEYS),
    ("integrators", "Side by side", INTEGRATOR_KEYS),
    ("directions", "Boresights in space", &["sky", "around", "ground"]),
    (
        "limits",
        "Inputs, rates and momenta",
        &[
            "inputs",
            "forces",
            "firings",
            "switching",
            "rates",
            "wheel_momentum",
            "position",
            "velocity",
            "clearance",
        ],
    ),
    ("flight", "In flight", &["pointing", "flown_pointing", "corrections", "flown_commands"]),
    ("attitude", "Attitude", &["euler", "quaternion", "error"]),
    (
        "costates",
        "Costates and Hamiltonian",
        &["costates_attitude", "costates_momentum", "costates_position", "costates_linear", "hamiltonian"],
    ),
    ("kept", "What is conserved", &["energy", "angular_momentum", "orthogonality"]),
    ("convergence", "Convergence", &["convergence"]),
];

/// Contents of a page, from which its HTML text is written.
pub(super) struct Content<'a> {
    pub name: &'a str,
    pub words: &'a Words,
    /// Headline figures of the page.
    pub tiles: Vec<Tile>,
    /// Sentences that state what is proved about the plan.
    pub proved: Vec<String>,
    pub shown: Vec<Shown>,
    /// Missing pictures: the identifier of their group, and the reason why they are missing.
    pub missing: Vec<(&'static str, String)>,
    /// Table above the pictures of a group, with the identifier of this group.
    pub grouped: Option<(&'static str, Table)>,
    pub tables: Vec<Table>,
    /// Animated body as data for the script, or `null` if no body is shown.
    pub body: Value,
    /// The number of nodes of the trajectory.
    pub nodes: usize,
}

/// Returns the page of a plan; `words` are the texts at its top. `sequence` is the sequence of the
/// Euler angles, one of [`slewkit_files::export::EULER_SEQUENCES`]. `flown` has the feedback gains
/// and uncertainties of the plan, and the margins for its chance constraints.
pub fn plan_page(
    problem: &Problem,
    settings: &Settings,
    plan: &Plan,
    identity: &Identity,
    flown: (&ClosedLoop, Option<&MarginsRecord>),
    sequence: &str,
) -> String {
    let (closed_loop, margins) = flown;
    let subject = &Subject::new(problem, plan, identity, sequence).flown_with(closed_loop);
    let (verdict, tone) = summary::verdict(plan);
    let parts = |lines: &[String]| lines.iter().map(|line| summary::parts(line)).collect::<Vec<_>>();
    let mut summary = parts(&summary::told(problem, settings, plan, identity));
    if let Some(beside) = subject.beside() {
        summary.extend(parts(&summary::flown::beside(problem, closed_loop, beside, margins)));
    }
    summary.extend(labelled("would do", &summary::remedies(problem, &plan.solution)));
    summary.extend(maneuver(problem));
    summary.extend(named(identity));
    let details = parts(&summary::details(false, problem, settings, plan, identity));
    written(&Content {
        name: &problem.name,
        words: &Words { verdict: verdict.into(), tone, summary, details },
        tiles: tiles(subject),
        proved: proved(subject),
        shown: pictures(subject),
        missing: hamiltonian_missing(subject).into_iter().chain(flight_missing(subject)).collect(),
        grouped: flight::table(subject).map(|table| ("flight", table)),
        tables: tables(subject),
        body: body(subject),
        nodes: subject.trajectory().time.len(),
    })
}

/// Returns the reason why the page has no chart of the Hamiltonian. Returns `None` if it has the
/// chart, or if the plan has no trajectory.
fn hamiltonian_missing(subject: &Subject) -> Option<(&'static str, String)> {
    let reason = hamiltonian::missing(subject).filter(|_| !subject.trajectory().time.is_empty())?;
    Some(("costates", format!("No Hamiltonian: {reason}.")))
}

/// Returns the reason why the page shows no flights with gains and uncertainties. Returns `None` if
/// it shows them, or if the spec does not request them.
fn flight_missing(subject: &Subject) -> Option<(&'static str, String)> {
    let (_, beside) = subject.flight.as_ref()?;
    let error = beside.as_ref().err()?;
    Some(("flight", format!("No gains and no covariance for this plan: {error}.")))
}

/// Returns the texts as lines. The first line has the label `label`; the labels of all other lines
/// are empty.
fn labelled(label: &str, texts: &[String]) -> Vec<(String, String)> {
    let told = texts.iter().enumerate();
    told.map(|(index, text)| (if index == 0 { label.into() } else { String::new() }, text.clone())).collect()
}

/// Returns the rows of the table that describes the maneuver: body, start and end.
fn maneuver(problem: &Problem) -> Vec<(String, String)> {
    let row = |values: &[f64]| values.iter().map(|value| rounded(*value, 5)).collect::<Vec<_>>().join(", ");
    let inertia = problem.body.inertia.j();
    let rows: Vec<String> =
        (0..3).map(|index| format!("[{}]", row(inertia.row(index).transpose().as_slice()))).collect();
    let state = |state: &State| {
        let quaternion = slewkit::lie::quaternion_from_rotation(&state.attitude);
        let rate = state.angular_velocity.map(f64::to_degrees);
        format!("quaternion wxyz ({}), rate ({}) deg/s in body axes", row(&quaternion), row(rate.as_slice()))
    };
    let told = [
        ("inertia", format!("{} kg·m²", rows.join(", "))),
        ("start", state(&problem.start)),
        ("end", state(&problem.end)),
    ];
    told.map(|(label, text)| (label.to_string(), text)).to_vec()
}

/// Returns the rows with the names of the spacecraft and the frames, and the calendar date of the
/// start.
fn named(identity: &Identity) -> Vec<(String, String)> {
    let told = [
        ("object", identity.object.clone()),
        ("epoch", identity.epoch.map(|epoch| epoch.to_string())),
        ("attitudes", identity.frames()),
    ];
    told.into_iter().filter_map(|(label, text)| Some((label.to_string(), text?))).collect()
}

/// Returns the HTML text of a page.
pub(super) fn written(content: &Content) -> String {
    let Content { name, words, tiles, proved, shown, missing: _, grouped: _, tables, body, nodes } = content;
    let name = if name.is_empty() { "Without a name" } else { name };
    let mut html = String::new();
    head(&mut html, name);
    verdict(&mut html, name, words);
    write_tiles(&mut html, tiles);
    section(&mut html, "summary", "Summary", |html| summary(html, &words.summary));
    if !body.is_null() {
        section(&mut html, "body", "The body in motion", stage);
    }
    let folded = ["costates", "convergence"];
    for (id, heading, keys) in GROUPS.into_iter().filter(|(id, ..)| !folded.contains(id)) {
        group(&mut html, content, id, heading, keys);
    }
    for table in tables {
        let id = table.title.to_lowercase().replace(' ', "-");
        section(&mut html, &id, table.title, |html| write_table(html, table));
    }
    if !proved.is_empty() {
        section(&mut html, "proved", "What is proved", |html| {
            html.push_str("<ul class=\"proved\">\n");
            for sentence in proved {
                let _ = writeln!(html, "<li>{}</li>", escape(sentence));
            }
            html.push_str("</ul>\n");
        });
    }
    if !words.details.is_empty() {
        html.push_str("<details class=\"details\">\n<summary>How it was found</summary>\n");
        section(&mut html, "found", "Method, residuals, witnesses", |html| summary(html, &words.details));
        for (id, heading, keys) in GROUPS.into_iter().filter(|(id, ..)| folded.contains(id)) {
            group(&mut html, content, id, heading, keys);
        }
        html.push_str("</details>\n");
    } else {
        for (id, heading, keys) in GROUPS.into_iter().filter(|(id, ..)| folded.contains(id)) {
            group(&mut html, content, id, heading, keys);
        }
    }
    foot(&mut html, !shown.is_empty(), *nodes);
    // In JSON, `\u003c` means `<`. No other character of the JSON text has a meaning in HTML at
    // this place.
    let data = document(shown, body).to_string().replace('<', "\\u003c");
    let _ = writeln!(html, "<script type=\"application/json\" id=\"data\">{data}</script>");
    let _ = writeln!(html, "<script>\n\"use strict\";\n(() => {{\n{}}})();\n</script>", SCRIPT.concat());
    html.push_str("</body>\n</html>\n");
    html
}

fn head(html: &mut String, name: &str) {
    let _ = write!(
        html,
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'; \
         script-src 'unsafe-inline'; img-src data:\">\n\
         <title>{}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n",
        escape(name)
    );
}

fn verdict(html: &mut String, name: &str, words: &Words) {
    let (class, sign) = (words.tone.class(), words.tone.sign());
    let _ = write!(
        html,
        "<header>\n<h1>{}</h1>\n<p class=\"verdict {class}\"><span aria-hidden=\"true\">{sign}</span> \
            {}</p>\n</header>\n\
         <noscript><p class=\"remark\">The pictures need JavaScript; words and tables are below, and `slew plot` draws \
         files.</p></noscript>\n<main>\n",
        escape(name),
        escape(&words.verdict)
    );
}

/// Writes the headline figures of a page as HTML.
fn write_tiles(html: &mut String, tiles: &[Tile]) {
    if tiles.is_empty() {
        return;
    }
    html.push_str("<dl class=\"tiles\">\n");
    for Tile { name, value, note } in tiles {
        let [name, value, note] = [name, value, note].map(|text| escape(text));
        let _ = writeln!(html, "<div><dt>{name}</dt><dd><b>{value}</b><small>{note}</small></dd></div>");
    }
    html.push_str("</dl>\n");
}

fn section(html: &mut String, id: &str, heading: &str, content: impl FnOnce(&mut String)) {
    let _ = writeln!(html, "<section id=\"{id}\">\n<h2>{}</h2>", escape(heading));
    content(html);
    html.push_str("</section>\n");
}

/// Writes a group of pictures, or the reason why a picture is missing.
fn group(html: &mut String, content: &Content, id: &str, heading: &str, keys: &[&str]) {
    let shown: Vec<&Shown> = content.shown.iter().filter(|shown| keys.contains(&shown.key)).collect();
    let missing: Vec<&String> =
        content.missing.iter().filter(|(section, _)| *section == id).map(|(_, reason)| reason).collect();
    let table = content.grouped.as_ref().filter(|(section, _)| *section == id);
    if shown.is_empty() && missing.is_empty() && table.is_none() {
        return;
    }
    section(html, id, heading, |html| {
        if let Some((_, table)) = table {
            write_table(html, table);
        }
        figures(html, &shown);
        for reason in missing {
            let _ = writeln!(html, "<p class=\"remark\">{}</p>", escape(reason));
        }
    });
}

fn summary(html: &mut String, lines: &[(String, String)]) {
    html.push_str("<dl class=\"summary\">\n");
    for (index, (label, text)) in lines.iter().enumerate() {
        if !label.is_empty() || index == 0 {
            let _ = writeln!(html, "<dt>{}</dt>", escape(label));
        }
        let _ = writeln!(html, "<dd>{}</dd>", escape(text));
    }
    html.push_str("</dl>\n");
}

fn figures(html: &mut String, shown: &[&Shown]) {
    html.push_str("<div class=\"figures\">\n");
    for shown in shown {
        let title = escape(shown.picture.title());
        let mut remark = match &shown.picture {
            Picture::Chart(chart) => chart.subtitle.clone(),
            Picture::Sky(sky) => sky.subtitle.clone(),
            Picture::Map(map) => map.subtitle.clone(),
            Picture::Ground(ground) => ground.subtitle.clone(),
            Picture::Gantt(gantt) => gantt.subtitle.clone(),
        };
        if !remark.is_empty() && !shown.remark.is_empty() {
            remark.push_str("; ");
        }
        remark.push_str(&shown.remark);
        // The caption below the picture contains its title and subtitle.
        let (title_of, subtitle) = (String::new(), String::new());
        let bare = match &shown.picture {
            Picture::Map(map) => Some(Map { title: title_of, subtitle, ..map.clone() }.svg()),
            Picture::Ground(ground) => Some(Ground { title: title_of, subtitle, ..ground.clone() }.svg()),
            Picture::Gantt(gantt) => Some(Gantt { title: title_of, subtitle, ..gantt.clone() }.svg()),
            Picture::Chart(_) | Picture::Sky(_) => None,
        };
        if let Some(svg) = bare {
            let key = shown.key;
            let remark = escape(&remark);
            let _ = writeln!(
                html,
                "<figure id=\"fig-{key}\"><figcaption><b>{title}</b> <span class=\"remark\">{remark}</span>\
                    </figcaption>\
                 {svg}</figure>"
            );
            continue;
        }
        let _ = writeln!(
            html,
            "<figure id=\"fig-{0}\" data-key=\"{0}\"><figcaption><b>{title}</b> <span class=\"remark\">{1}</span>\
             </figcaption><div class=\"plot\" tabindex=\"0\" role=\"img\" aria-label=\"{title}\"></div>\
             <div class=\"legend\"></div></figure>",
            shown.key,
            escape(&remark)
        );
    }
    html.push_str("</div>\n");
}

/// Largest number of characters of a table cell that is not broken into lines.
const LONG_CELL: usize = 48;

fn write_table(html: &mut String, table: &Table) {
    html.push_str("<div class=\"wide\"><table>\n<thead><tr>");
    for cell in &table.head {
        let _ = write!(html, "<th scope=\"col\">{}</th>", escape(cell));
    }
    html.push_str("</tr></thead>\n<tbody>\n");
    for row in &table.rows {
        html.push_str("<tr>");
        for cell in row {
            let class = if cell.chars().count() > LONG_CELL { " class=\"text\"" } else { "" };
            let _ = write!(html, "<td{class}>{}</td>", escape(cell));
        }
        html.push_str("</tr>\n");
    }
    html.push_str("</tbody>\n</table></div>\n");
    if !table.remark.is_empty() {
        let _ = writeln!(html, "<p class=\"remark\">{}</p>", escape(table.remark));
    }
}

fn stage(html: &mut String) {
    html.push_str(
        "<div class=\"stage\"><canvas id=\"stage\" role=\"img\" aria-label=\"the body as it turns\" \
        tabindex=\"0\"></canvas></div>\n<div class=\"controls\"><button id=\"play\" \
        type=\"button\">Play</button><input id=\"slider\" type=\"range\" min=\"0\" max=\"1000\" \
        value=\"0\" step=\"1\" aria-label=\"time\"><output id=\"clock\"></output></div>\n<div \
        class=\"legend\" id=\"stage-legend\"></div>\n<p class=\"remark\">A box represents the body, \
        with its principal moments where they are known. Drag, or use the arrow keys, to change the \
        view. The slider is the time of the cursor in every chart.</p>\n",
    );
}

fn foot(html: &mut String, charts: bool, nodes: usize) {
    html.push_str("</main>\n<footer>\n<p>");
    if charts {
        html.push_str(
            "In the charts: move or tap for values, drag to zoom, double click or 0 for the whole \
            chart; with the keyboard, arrows move the cursor, + and − zoom.",
        );
    }
    if nodes > MOST_POINTS {
        let _ = write!(
            html,
            " Curves show at most {MOST_POINTS} of {nodes} points, with the lowest and the highest \
            of each stretch; the source file of the report has all points."
        );
    }
    let _ = writeln!(html, "</p>\n<p>{}</p>\n</footer>", escape(GENERATOR));
}
