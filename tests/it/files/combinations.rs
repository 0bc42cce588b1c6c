//! The tables of `docs/combinations.md`: which combinations are planned. `evidence -- combinations`
//! plans every cell.

use evidence::ROOT;
use evidence::combinations::{Became, all, cell};
use std::fs;

fn page() -> String {
    fs::read_to_string(format!("{ROOT}/docs/combinations.md")).unwrap()
}

#[test]
fn every_combination_that_is_refused_is_told_on_its_page() {
    let page = page();
    let mut refused = 0;
    for of in all() {
        let told = cell(&page, of).unwrap_or_else(|| panic!("{of:?} has no cell"));
        assert_eq!(told.strip_prefix("no: ").map(String::from), of.refused(), "{of:?}: {told}");
        refused += usize::from(told.starts_with("no: "));
    }
    assert!((1..all().len()).contains(&refused));
}

/// Some of the combinations that take a tenth of a second are planned, each kind of end and input
/// among them.
#[test]
fn a_combination_that_is_quick_on_its_page_is_planned() {
    const EVERY: usize = 4;
    const MOST: f64 = 60.0;
    let page = page();
    let quick: Vec<_> =
        all().into_iter().filter(|of| cell(&page, *of).unwrap().starts_with("< 0.1")).collect();
    assert!(quick.len() > 20);
    for of in quick.into_iter().step_by(EVERY) {
        let became = of.became(MOST);
        assert!(matches!(became, Became::Planned(_)), "{of:?}: {became:?}");
    }
}
