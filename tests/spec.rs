//! Spec files: what they mean, what is refused, and that no input breaks the reader.

use slewkit::spec::{self, Format};

#[test]
fn template_loads_without_a_word() {
    let loaded = spec::from_str(spec::template(), "template.toml", Format::Toml, &[]);
    let loaded = loaded.unwrap_or_else(|errors| panic!("{errors}"));
    assert!(loaded.warnings.is_empty());
    assert_eq!(loaded.problem.steps, 100);
}
