//! Feature `serde`: plain data comes back, and a file cannot smuggle in a shape that is none.

use geometry::nalgebra::{Point3, Vector3};
use geometry::{Asphere, AsphereShape, EulerAngles, Line, PlanarMap, Surface, Wrench};
use serde::Serialize;
use serde::de::DeserializeOwned;

fn returned<T: Serialize + DeserializeOwned>(value: &T) -> T {
    let text = serde_json::to_string(value).expect("plain data");
    serde_json::from_str(&text).expect("as written")
}

#[test]
fn plain_data_comes_back() {
    let wrench = Wrench::of_force(Vector3::new(0.1, -0.2, -40.0), &Point3::new(3.0, 4.0, 5.0));
    assert_eq!(returned(&wrench), wrench);
    let line = Line::new(Point3::new(1.0, 2.0, 3.0), Vector3::new(0.3, 0.4, 0.5)).unwrap();
    assert_eq!(returned(&line), line);
    let map = PlanarMap::rigid(0.3, true, [1.0, 2.0].into());
    assert_eq!(returned(&map), map);
    assert_eq!(returned(&map.parts()), map.parts());
    let angles = EulerAngles { alpha_rad: 0.1, beta_rad: 0.2, gamma_rad: 0.3 };
    assert_eq!(returned(&angles), angles);
}

#[test]
fn aspheres_are_checked_on_the_way_in() {
    let shape = AsphereShape::on_axis(25.0, 0.5, vec![1e-6, -1e-9], 30.0);
    let asphere = Asphere::new(shape).unwrap();
    let back = returned(&asphere);
    assert_eq!(back, asphere);
    let query = Point3::new(3.0, 4.0, 5.0);
    assert_eq!(back.closest_point(&query), asphere.closest_point(&query));

    let too_wide = serde_json::to_string(&AsphereShape::on_axis(25.0, 0.5, vec![], 60.0)).unwrap();
    let said = serde_json::from_str::<Asphere>(&too_wide).unwrap_err().to_string();
    assert!(said.contains("the conic ends at"), "{said}");
}
