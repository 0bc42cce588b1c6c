//! Tests that compare the charts of flights with the covariances.

use super::super::{page, pictures};
use super::*;
use crate::draw::{Picture, Sky};
use slewkit::plan::{self, Plan, Silent};
use slewkit_files::flown::UncertaintyRecord;
use slewkit_files::spec::{self, Format, Loaded, Override};

/// Returns the shipped slew with gains and uncertainty, without its chance constraint and on fewer
/// steps, and its plan.
fn planned() -> (Loaded, Plan) {
    let text = include_str!("../../../../problems/flies.toml").replace("chance = 0.01\n", "");
    let fewer = [Override::parse("maneuver.steps=60").unwrap()];
    let mut loaded = spec::from_str(&text, "spec", Format::Toml, &fewer).unwrap();
    let plan = plan::plan(&loaded.problem, &loaded.settings, None, &mut Silent).unwrap();
    loaded.problem = plan.solution.on_grid(&loaded.problem);
    (loaded, plan)
}

fn subject<'a>(loaded: &'a Loaded, plan: &'a Plan) -> Subject<'a> {
    Subject::new(&loaded.problem, plan, &loaded.identity, "zyx").flown_with(&loaded.closed_loop)
}

fn curves(shown: &[Shown], key: &str) -> Vec<(String, Vec<(f64, f64)>)> {
    let chart = shown.iter().find(|shown| shown.key == key).unwrap();
    let Picture::Chart(chart) = &chart.picture else { panic!("{key} is no chart") };
    chart.curves.iter().map(|curve| (curve.name.clone(), curve.shape.points())).collect()
}

fn map(shown: &[Shown]) -> (&Sky, &str) {
    let shown = shown.iter().find(|shown| shown.key == "sky").unwrap();
    let Picture::Sky(sky) = &shown.picture else { panic!("no map") };
    (sky, &shown.remark)
}

#[test]
fn curves_table_and_ellipses_are_those_of_the_covariances() {
    let (loaded, plan) = planned();
    let subject = subject(&loaded, &plan);
    let shown = pictures(&subject);
    let beside = subject.beside().unwrap();

    // Checks the radii: at the end they equal the radii in the plan file, radii of higher
    // probability are larger, and gains reduce them.
    let uncertainty = loaded.closed_loop.uncertainty.as_ref();
    let record = UncertaintyRecord::new(&loaded.problem, beside, uncertainty).unwrap();
    let closed = record.closed_loop.as_ref().unwrap();
    let radii = curves(&shown, "pointing");
    let names: Vec<&str> = radii.iter().map(|(name, _)| name.as_str()).collect();
    let of = |name: &str| &radii.iter().find(|(other, _)| other == name).unwrap().1;
    assert_eq!(names.len(), 6, "{names:?}");
    for (name, radius) in [
        ("99.73 %, closed loop", closed.pointing[0].within_9973_deg),
        ("99.73 %, open loop", record.open_loop.pointing[0].within_9973_deg),
    ] {
        let last = of(name).last().unwrap();
        assert_eq!(last.0, 60.0);
        // Without half a kick at the nodes, the last state is the state at the end.
        assert!((last.1 / radius - 1.0).abs() < 1e-9, "{name}: {} and {radius}", last.1);
    }
    for name in ["closed loop", "open loop"] {
        let [outer, middle, inner] = ["99.73 %", "90 %", "50 %"].map(|level| of(&format!("{level}, {name}")));
        assert_eq!(outer.len(), 61);
        assert!(outer.iter().zip(middle).zip(inner).all(|((a, b), c)| a.1 > b.1 && b.1 > c.1));
    }

    // The sum of the room for corrections and the planned input is the limit.
    let inputs = curves(&shown, "corrections");
    assert_eq!(inputs.len(), 6);
    for (axis, (name, left)) in inputs[3..].iter().enumerate() {
        assert!(name.starts_with("left to "), "{name}");
        for (step, (time, left)) in left.iter().enumerate() {
            assert_eq!(*time, beside.linear.times()[step]);
            assert!((left + beside.linear.inputs(step)[axis].abs() - 2.0).abs() < 1e-12);
        }
    }
    assert!((inputs[1].1[7].1 / closed.input_sigma[7][1] - 3.0).abs() < 1e-12);

    // Compares the percentiles of the flown cases with the linear theory, and checks a band of
    // three deviations about the commands.
    let flown = curves(&shown, "flown_pointing");
    assert_eq!(flown.len(), 6);
    for (marks, lines) in flown[1..3].iter().zip(&flown[4..]) {
        assert!(marks.0.ends_with("flown") && lines.0.ends_with("linear"), "{} {}", marks.0, lines.0);
        for ((time, mark), (_, value)) in marks.1.iter().zip(&lines.1) {
            // For 1000 cases the tolerance is three standard errors of the median, and four of the
            // 90 % quantile.
            assert!((mark / value - 1.0).abs() < 0.15, "{} at {time} s: {mark} and {value}", marks.0);
        }
    }
    let commands = curves(&shown, "flown_commands");
    assert_eq!(commands.len(), 6);
    for input in 0..3 {
        let (planned, band) = (&commands[input].1, &commands[3 + input].1);
        assert_eq!(planned[7].1, beside.linear.inputs(7)[input]);
        for (step, ends) in band.chunks_exact(2).enumerate() {
            let half = 0.5 * (ends[1].1 - ends[0].1);
            let ratio = half / (3.0 * closed.input_sigma[step][input]);
            assert!(ratio > 0.75 && ratio < 1.35, "input {input}, step {step}: {ratio}");
        }
    }

    // The quadratic form of the covariance is constant on each ellipse, −2 ln(1 − p).
    let (sky, remark) = map(&shown);
    let (rings, factor) = rings(&subject);
    assert_eq!((rings.len(), &rings), (2 * (RINGS + 1), &sky.rings));
    assert!(remark.contains("filled under the gains"), "{remark}");
    assert_eq!(factor, 1);
    let nodes: Vec<usize> = some_nodes(61, RINGS).collect();
    let boresight = Vector3::x();
    let level = -2.0 * (1.0 - Radius::LEVEL).ln();
    for (covariance, rings) in
        [(beside.closed.as_ref(), &rings[..=RINGS]), (beside.open.as_ref(), &rings[RINGS + 1..])]
    {
        for (ring, node) in rings.iter().zip(&nodes) {
            let attitude = beside.linear.node(*node).0;
            let lever = slewkit::lie::hat(&boresight);
            let on_sky = lever * of_attitude(&covariance.unwrap().states[*node]) * lever.transpose();
            let across = on_sky.fixed_view::<2, 2>(1, 1).into_owned().try_inverse().unwrap();
            for point in &ring.points {
                let seen = attitude.transpose() * point;
                let aside = seen - boresight * seen.x;
                let plane = aside.fixed_rows::<2>(1) * (seen.x.acos() / aside.norm());
                let form = plane.dot(&(across * plane));
                // The acos of a number near one loses half of the digits.
                assert!((form / level - 1.0).abs() < 1e-5, "node {node}: {form} and {level}");
            }
        }
    }

    let table = table(&subject).unwrap();
    assert_eq!(table.head, ["", "open loop", "closed loop"]);
    let row = table.rows.iter().find(|row| row[0].starts_with("Sun: chance")).unwrap();
    assert!(row[2].starts_with(&significant(closed.chances[0].largest, 2)), "{row:?}");
    let row = table.rows.iter().find(|row| row[0].contains("99.73 %")).unwrap();
    assert_eq!(row[1], significant(record.open_loop.pointing[0].within_9973_deg, 3));
}

/// Checks a spec without feedback and uncertainty, one with gains only, and one without gains.
#[test]
fn what_is_not_asked_is_not_shown() {
    let (mut loaded, plan) = planned();
    let page_of = |loaded: &Loaded| {
        let Loaded { problem, settings, identity, closed_loop, .. } = loaded;
        page::plan_page(problem, settings, &plan, identity, (closed_loop, None), "zyx")
    };
    let page = page_of(&loaded);
    assert!(page.contains("<section id=\"flight\">") && page.contains("<dt>uncertain</dt>"));
    loaded.closed_loop.feedback = None;
    let shown = pictures(&subject(&loaded, &plan));
    assert_eq!(curves(&shown, "pointing").len(), 3);
    assert!(shown.iter().all(|shown| shown.key != "corrections"));
    assert!(map(&shown).0.rings.iter().all(|ring| !ring.filled));
    assert_eq!(table(&subject(&loaded, &plan)).unwrap().head, ["", "open loop"]);
    loaded.closed_loop.uncertainty = None;
    let page = page_of(&loaded);
    assert!(
        !page.contains("<section id=\"flight\">")
            && map(&pictures(&subject(&loaded, &plan))).0.rings.is_empty()
    );
}

#[test]
fn nodes_are_spread_over_the_plan_with_both_ends() {
    for (count, most, wanted) in
        [(5, 10, vec![0, 1, 2, 3, 4]), (9, 4, vec![0, 2, 4, 6, 8]), (1, 4, vec![0]), (0, 4, vec![])]
    {
        assert_eq!(some_nodes(count, most).collect::<Vec<_>>(), wanted, "{count}");
    }
    let far: Vec<usize> = some_nodes(4001, 120).collect();
    assert_eq!((far.len(), far[120]), (121, 4000));
}
