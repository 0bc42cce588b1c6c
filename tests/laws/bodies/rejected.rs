//! The shapes and bodies that constructors reject, with the numbers in the message.

use slewkit::Vector3;
use slewkit::mechanics::full_body::*;

fn point(mass: f64, x: f64) -> MassPoint {
    MassPoint { mass, position: Vector3::new(x, 0.0, 0.0) }
}

#[test]
fn clouds_that_are_none() {
    let error = |points: Vec<MassPoint>| PointCloud::new(points).unwrap_err().to_string();
    assert_eq!(error(vec![]), "points of a cloud: 0; the number must be from 1 to 10000000");
    assert_eq!(error(vec![point(-1.0, 0.0)]), "mass of a point is -1; it must be positive");
    assert_eq!(error(vec![point(f64::NAN, 0.0)]), "mass of a point is not finite");
    assert_eq!(error(vec![point(1.0, f64::INFINITY)]), "position of a point is not finite");
    assert!(
        error(vec![point(1.0, 1.0), point(3.0, 0.0)]).starts_with("the mass center is at (0.25, 0, 0) m")
    );
    let (cloud, center) = PointCloud::centered(vec![point(1.0, 1.0), point(3.0, 0.0)]).unwrap();
    assert_eq!(center.x, 0.25);
    assert_eq!(cloud.points()[1].position.x, -0.25);
    assert_eq!(
        error(vec![point(f64::MAX, 0.0), point(f64::MAX, 0.0)]),
        "sum of the masses of the points is not finite"
    );
}

#[test]
fn systems_that_are_none() {
    let error = |g, bodies| MutualGravity::new(g, bodies).unwrap_err().to_string();
    let one = || Attractor::point(1.0).unwrap();
    assert_eq!(error(1.0, vec![]), "bodies: 0; the number must be from 1 to 2000");
    assert_eq!(error(1.0, vec![one(); 2001]), "bodies: 2001; the number must be from 1 to 2000");
    assert_eq!(error(0.0, vec![one()]), "gravitational constant is 0; it must be positive");
    let huge = vec![Attractor::point(1e200).unwrap(); 2];
    assert_eq!(error(1.0, huge), "gravitational constant times the square of the masses is not finite");
    assert!(Attractor::point(-1.0).is_err());
    let rod = Dumbbell { mass: 1.0, length: 0.0, sphere_radius: 0.1 };
    assert_eq!(
        Dumbbells::new(1.0, &[rod]).unwrap_err().to_string(),
        "length of a dumbbell is 0; it must be positive"
    );
    assert!(
        Dumbbell { length: 1.0, sphere_radius: 0.0, ..rod }.body().is_err(),
        "a rod has no inertia about itself"
    );
}
