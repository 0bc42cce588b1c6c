//! Every shipped sequence is planned as by a user, and compared with numbers that were not computed
//! with this crate.

use slewkit::plan::{Silent, Status};
use slewkit::sequence::order::Proof;
use slewkit::sequence::{Ordering, SequencePlan};
use slewkit_files::export::SequenceFile;
use slewkit_files::spec::{self, Expect, Format, LoadedSequence, Spec};
use std::path::PathBuf;

fn files() -> Vec<PathBuf> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../problems/sequences");
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
}

fn faults(loaded: &LoadedSequence, plan: &SequencePlan) -> Vec<String> {
    let mut faults = Vec::new();
    let sequence = &loaded.sequence;
    let expect: &Expect = loaded.expect.as_ref().unwrap();
    if plan.status() != Status::Solved {
        faults.push(format!("{:?}", plan.status()));
    }
    let continuous =
        || plan.legs.iter().map(|leg| leg.plan.solution.switching.as_ref().unwrap().continuous_cost);
    for (expected, found) in [
        (expect.cost, plan.cost),
        (expect.continuous_cost, expect.continuous_cost.map_or(0.0, |_| continuous().sum())),
    ] {
        if let Some(expected) =
            expected.filter(|expected| (found - expected.value).abs() > expected.tolerance)
        {
            faults.push(format!("cost {found}, expected {expected:?}"));
        }
    }
    let order: Vec<&str> = plan.legs.iter().map(|leg| &*sequence.stops[leg.stop].name).collect();
    if expect.order.as_ref().is_some_and(|expected| *expected != order) {
        faults.push(format!("order {order:?}"));
    }
    let proved = plan.order.as_ref().map(|order| (order.proof, order.gap()));
    match (sequence.order, proved) {
        (Ordering::Given, None) => {}
        (_, Some((Proof::AllOrders, 0.0))) => {}
        // The median of random sets is within five percent.
        (_, Some((Proof::LowerBound, gap))) if gap < 0.05 => {}
        (_, proved) => faults.push(format!("{proved:?}")),
    }
    for leg in &plan.legs {
        let found = leg.plan.verification.as_ref().unwrap();
        let margin = found.margins.iter().map(|margin| margin.scaled).fold(f64::INFINITY, f64::min);
        if expect.margin_at_least.is_some_and(|least| margin < least) {
            faults.push(format!("margin {margin}"));
        }
        let missed = leg.plan.solution.terminal.attitude_rad;
        if expect.terminal_error.is_some_and(|most| missed > most) {
            faults.push(format!("terminal error {missed}"));
        }
    }
    faults
}

/// The plan agrees with `[expect]`, its file is verified, and reading the file gives the same plan.
#[test]
fn every_sequence_comes_to_what_it_says() {
    let mut count = 0;
    for path in files() {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let Ok(Spec::Sequence(loaded)) = spec::load(&path, Format::Toml, &[]) else { panic!("{name}") };
        let plan = loaded.sequence.plan(&loaded.settings, &mut Silent).unwrap();
        assert_eq!(faults(&loaded, &plan), Vec::<String>::new(), "{name}");
        let file = SequenceFile::new(&loaded, &plan);
        let mut text = Vec::new();
        file.write(&mut text).unwrap();
        let read = SequenceFile::read(&text[..]).unwrap();
        assert_eq!(read.record, file.record, "{name}");
        let held = read.record.spec.as_ref().unwrap().read_sequence("held", &[]).unwrap().unwrap();
        let debug = |loaded: &LoadedSequence| {
            format!(
                "{:#?} {:#?} {:?}",
                loaded.sequence.craft.actuation, loaded.sequence.stops, loaded.sequence.order
            )
        };
        assert_eq!(debug(&held), debug(&loaded), "{name}");
        for loaded in [&held, &*loaded] {
            let judged = read.judge(loaded, &|| false).unwrap();
            let failed: Vec<_> = judged.checks.iter().filter(|check| !check.passed).collect();
            assert!(judged.passed(), "{name}: {failed:?}");
        }
        count += 1;
    }
    assert!(count >= 7, "{count}");
}
