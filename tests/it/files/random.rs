//! Laws that hold for every random spec.

use super::good;
use evidence::random_specs::random_spec;

#[test]
fn random_specs_of_every_kind_are_read() {
    for index in 0..260 {
        let spec = random_spec(index);
        let name = good(&spec.text, &[]).problem.name;
        assert_eq!(name, format!("{} № {index}", spec.kind));
    }
}
