//! Writes rows as keywords and values, as XML, or as a table.

use super::{Kind, Notation, Row, Style, date, number, numbers};
use std::fmt::Write as _;

/// Returns the bytes of the file.
pub fn file(style: &Style, rows: &[Row]) -> Vec<u8> {
    let text = match style.notation {
        Notation::Keywords => keywords(style, rows),
        Notation::Xml => xml(style, rows),
        Notation::Table => table(style, rows),
    };
    let text = text.replace('\n', style.line_end);
    let mark = if style.mark { "\u{feff}" } else { "" };
    format!("{mark}{text}").into_bytes()
}

/// Returns the indices of the first and the last row of every block.
fn blocks(style: &Style, rows: &[Row]) -> Vec<(usize, usize)> {
    let last = rows.len() - 1;
    let inner: Vec<usize> = style.blocks.iter().copied().filter(|at| *at > 0 && *at < last).collect();
    let starts = std::iter::once(0).chain(inner.iter().map(|at| at + usize::from(style.apart)));
    starts.zip(inner.iter().copied().chain([last])).collect()
}

fn sequence_name(axes: [usize; 3], first_version: bool) -> String {
    axes.iter()
        .map(|axis| if first_version { ["1", "2", "3"][*axis] } else { ["X", "Y", "Z"][*axis] })
        .collect()
}

/// Returns the metadata keys of a block and their values, in the order of the standard.
fn metadata(style: &Style, rows: &[Row]) -> Vec<(&'static str, String)> {
    let (a, b) = if style.body_is_a { (style.body, style.reference) } else { (style.reference, style.body) };
    let mut keys: Vec<(&'static str, String)> =
        vec![("OBJECT_NAME", "DEMO".into()), ("OBJECT_ID", "2026-001A".into())];
    if style.extra_keys {
        keys.push(("CENTER_NAME", "EARTH".into()));
    }
    keys.push(("REF_FRAME_A", a.into()));
    keys.push(("REF_FRAME_B", b.into()));
    if style.first_version {
        keys.push(("ATTITUDE_DIR", if style.a_to_b { "A2B" } else { "B2A" }.into()));
    }
    let ends = [rows.first(), rows.last()].map(|row| date(style, row.map_or(0.0, |row| row.time)));
    keys.push(("TIME_SYSTEM", style.scale.into()));
    keys.push(("START_TIME", ends[0].clone()));
    if style.extra_keys {
        keys.push(("USEABLE_START_TIME", ends[0].clone()));
        keys.push(("USEABLE_STOP_TIME", ends[1].clone()));
    }
    keys.push(("STOP_TIME", ends[1].clone()));
    let kind = match style.kind {
        Kind::Quaternion => "QUATERNION",
        Kind::QuaternionAngvel => "QUATERNION/ANGVEL",
        Kind::QuaternionDerivative => "QUATERNION/DERIVATIVE",
        Kind::Euler(_) => "EULER_ANGLE",
        Kind::EulerDerivative(_) => "EULER_ANGLE/DERIVATIVE",
        Kind::EulerAngvel(_) => "EULER_ANGLE/ANGVEL",
        Kind::Spin => "SPIN",
    };
    keys.push(("ATTITUDE_TYPE", kind.into()));
    if style.first_version && is_quaternion(style.kind) {
        keys.push(("QUATERNION_TYPE", if style.scalar_first { "FIRST" } else { "LAST" }.into()));
    }
    if let Kind::Euler(axes) | Kind::EulerDerivative(axes) | Kind::EulerAngvel(axes) = style.kind {
        keys.push(("EULER_ROT_SEQ", sequence_name(axes, style.first_version)));
    }
    if matches!(style.kind, Kind::QuaternionAngvel | Kind::EulerAngvel(_)) {
        let keyword = if style.rate_in_a { "REF_FRAME_A" } else { "REF_FRAME_B" };
        let name = if style.rate_in_a { a } else { b };
        keys.push(("ANGVEL_FRAME", if style.rate_by_keyword { keyword } else { name }.into()));
    }
    if style.extra_keys {
        keys.push(("INTERPOLATION_METHOD", "LAGRANGE".into()));
        keys.push(("INTERPOLATION_DEGREE", "5".into()));
    }
    if style.lower_values {
        for (key, value) in &mut keys {
            if !key.ends_with("_TIME") {
                *value = value.to_lowercase();
            }
        }
    }
    keys
}

fn is_quaternion(kind: Kind) -> bool {
    matches!(kind, Kind::Quaternion | Kind::QuaternionAngvel | Kind::QuaternionDerivative)
}

fn version(style: &Style) -> &'static str {
    if style.first_version { "1.0" } else { "2.0" }
}

fn keywords(style: &Style, rows: &[Row]) -> String {
    let mut lines = vec![
        format!("CCSDS_AEM_VERS = {}", version(style)),
        "CREATION_DATE = 2026-11-20T00:00:00".into(),
        "ORIGINATOR   =   TEST".into(),
    ];
    if style.comments {
        lines.insert(1, "COMMENT of the header".into());
    }
    for (from, to) in blocks(style, rows) {
        let own = &rows[from..=to];
        lines.extend([String::new(), "META_START".into()]);
        if style.comments {
            lines.push("COMMENT of the block = with a sign".into());
        }
        lines.extend(metadata(style, own).iter().map(|(key, value)| format!("{key} = {value}")));
        lines.extend(["META_STOP".into(), "DATA_START".into()]);
        if style.comments {
            lines.push("COMMENT of the data".into());
        }
        for (index, row) in own.iter().enumerate() {
            let mut values = numbers(style, row, from + index);
            if style.scalar_first && is_quaternion(style.kind) {
                values[..4].rotate_right(1);
                if style.kind == Kind::QuaternionDerivative {
                    values[4..8].rotate_right(1);
                }
            }
            let values: Vec<String> = values.iter().map(|value| number(style, *value)).collect();
            lines.push(format!("{} {}", date(style, row.time), values.join("  ")));
        }
        lines.push("DATA_STOP".into());
    }
    if style.lower_keys {
        for line in &mut lines {
            *line = match line.split_once(" = ") {
                Some((key, value)) if !line.starts_with("COMMENT") => {
                    format!("{} = {value}", key.to_lowercase())
                }
                _ if line.starts_with("META_") || line.starts_with("DATA_") => line.to_lowercase(),
                _ => line.clone(),
            };
        }
    }
    lines.join("\n") + "\n"
}

/// Returns the name of the XML element of a state, and the names of its parts with the names of
/// their numbers.
fn elements(kind: Kind, first_version: bool) -> (&'static str, Vec<(&'static str, Vec<&'static str>)>) {
    let quaternion = ("quaternion", vec!["Q1", "Q2", "Q3", "QC"]);
    let velocity = ("angVel", vec!["ANGVEL_X", "ANGVEL_Y", "ANGVEL_Z"]);
    let angles = vec!["ANGLE_1", "ANGLE_2", "ANGLE_3"];
    match kind {
        Kind::Quaternion if first_version => ("quaternionState", vec![quaternion]),
        Kind::Quaternion => ("quaternionEphemeris", vec![quaternion]),
        Kind::QuaternionAngvel => ("quaternionAngVel", vec![quaternion, velocity]),
        Kind::QuaternionDerivative => (
            "quaternionDerivative",
            vec![quaternion, ("quaternionDot", vec!["Q1_DOT", "Q2_DOT", "Q3_DOT", "QC_DOT"])],
        ),
        Kind::Euler(_) if first_version => {
            ("eulerAngle", vec![("rotationAngles", vec!["rotation1", "rotation2", "rotation3"])])
        }
        Kind::Euler(_) => ("eulerAngle", vec![("", angles)]),
        Kind::EulerDerivative(_) => (
            "eulerAngleDerivative",
            vec![("", angles), ("", vec!["ANGLE_1_DOT", "ANGLE_2_DOT", "ANGLE_3_DOT"])],
        ),
        Kind::EulerAngvel(_) => ("eulerAngleAngVel", vec![("", angles), ("", velocity.1)]),
        Kind::Spin => ("spin", vec![("", vec!["SPIN_ALPHA", "SPIN_DELTA", "SPIN_ANGLE", "SPIN_ANGLE_VEL"])]),
    }
}

/// Returns the unit of a number by its name.
fn unit(name: &str) -> Option<&'static str> {
    match name {
        "QC" | "Q1" | "Q2" | "Q3" => None,
        name if name.starts_with('Q') => Some("1/s"),
        name if name.starts_with("ANGVEL") || name.ends_with("_DOT") || name.ends_with("_VEL") => {
            Some("deg/s")
        }
        _ => Some("deg"),
    }
}

fn xml(style: &Style, rows: &[Row]) -> String {
    let Style { quote, prefix, .. } = *style;
    let attribute = |name: &str, value: &str| format!("{name}={quote}{value}{quote}");
    let mut text = format!("<?xml {} {}?>\n", attribute("version", "1.0"), attribute("encoding", "UTF-8"));
    if style.wrapped {
        let _ =
            writeln!(text, "<ndm {}>", attribute("xmlns:xsi", "http://www.w3.org/2001/XMLSchema-instance"));
    }
    let space =
        if prefix.is_empty() { String::new() } else { attribute("xmlns:n", "urn:ccsds:schema:ndmxml") };
    let _ = writeln!(
        text,
        "<{prefix}aem {space} {} {}>",
        attribute("id", "CCSDS_AEM_VERS"),
        attribute("version", version(style))
    );
    text.push_str(
        "<header><CREATION_DATE>2026-11-20T00:00:00</CREATION_DATE><ORIGINATOR>TEST</ORIGINATOR>\
        </header>\n<body>\n",
    );
    let (state, parts) = elements(style.kind, style.first_version);
    for (from, to) in blocks(style, rows) {
        let own = &rows[from..=to];
        text.push_str("<segment><metadata>\n");
        for (key, value) in metadata(style, own) {
            let _ = writeln!(text, "<{key}>{value}</{key}>");
        }
        text.push_str("</metadata>\n<data>\n");
        if style.comments {
            text.push_str("<!-- of the data --><COMMENT>and of the message</COMMENT>\n");
        }
        for (index, row) in own.iter().enumerate() {
            let mut values = numbers(style, row, from + index).into_iter();
            let _ = write!(text, "<attitudeState><{state}><EPOCH>{}</EPOCH>", date(style, row.time));
            for (part, names) in &parts {
                let (open, close) = if part.is_empty() {
                    (String::new(), String::new())
                } else {
                    (format!("<{part}>"), format!("</{part}>"))
                };
                text.push_str(&open);
                for (name, value) in names.iter().zip(values.by_ref()) {
                    let unit = unit(name)
                        .filter(|_| style.units)
                        .map_or(String::new(), |unit| format!(" {}", attribute("units", unit)));
                    let _ = write!(text, "<{name}{unit}>{}</{name}>", number(style, value));
                }
                text.push_str(&close);
            }
            let _ = writeln!(text, "</{state}></attitudeState>");
        }
        text.push_str("</data></segment>\n");
    }
    let _ = writeln!(text, "</body></{prefix}aem>");
    if style.wrapped {
        text.push_str("</ndm>\n");
    }
    text
}

fn table(style: &Style, rows: &[Row]) -> String {
    let unit = if style.degrees { "deg_s" } else { "rad_s" };
    let mut names: Vec<String> =
        ["time_s", "quaternion_x", "quaternion_y", "quaternion_z", "quaternion_w"].map(Into::into).into();
    if style.kind == Kind::QuaternionAngvel {
        names.extend(["x", "y", "z"].map(|axis| format!("angular_velocity_{axis}_{unit}")));
    }
    if style.quoted {
        names = names.iter().map(|name| format!("\"{name}\"")).collect();
    }
    // A column without a name is possible only if columns are separated by a character other than a
    // space.
    let index = style.index && style.separator != ' ';
    let sign = style.separator.to_string();
    let mut lines = Vec::new();
    if style.comments {
        lines.push("# of the table".to_string());
    }
    lines.push(if index { format!("{sign}{}", names.join(&sign)) } else { names.join(&sign) });
    for (k, row) in rows.iter().enumerate() {
        let time = format!("{:.*}", style.decimals_of_time, row.time);
        let values = numbers(style, row, k).into_iter().map(|value| number(style, value));
        let mut cells: Vec<String> = std::iter::once(time).chain(values).collect();
        if index {
            cells.insert(0, k.to_string());
        }
        lines.push(cells.join(&sign));
    }
    lines.join("\n") + "\n"
}
