//! Mistakes in the ranges of a laser tracer.

use super::{change, first, fixture, scale};
use crate::command::Case;

const RANGES: &str = "ranges.csv";
const DISPLACEMENT: &str = "displacement_mm";

/// A sound survey: six stations on four reflectors, nineteen steps each.
fn survey() -> Case {
    fixture("tracker-lm/nothing", &["case.toml", "stations.csv", "mounts.csv", RANGES])
}

fn replace(case: &Case, of: impl Fn(usize, &dyn Fn(usize) -> f64) -> f64) {
    change(case, RANGES, &[DISPLACEMENT], |n, old| {
        vec![format!("{}", of(n, &|row| old[row][0].parse().unwrap()))]
    });
}

/// Nothing can be fitted, and the refusal says this.
fn assert_refused(case: &Case, said: &str) {
    let ended = case.run("loop");
    assert_eq!(ended.code, 3, "{}", ended.stderr);
    assert!(ended.stderr.contains(said), "{}", ended.stderr);
}

#[test]
fn the_way_of_a_beam_there_and_back_is_no_scale() {
    for factor in [2.0, 0.5] {
        let case = survey();
        scale(&case, RANGES, &[DISPLACEMENT], factor);
        let (step, _) = first(&case);
        assert_eq!(step["effect"], "input:unit");
        let said = format!("multiply by {}", 1.0 / factor);
        assert!(step["description"].as_str().unwrap().contains(&said), "{step}");
    }
}

#[test]
fn a_displacement_that_stands_still_in_one_lock_is_named() {
    let case = survey();
    // Four steps of the third lock.
    replace(&case, |n, read| read(if (44..48).contains(&n) { 44 } else { n }));
    let (step, answer) = first(&case);
    assert_eq!(step["effect"], "input:stuck");
    assert!(step["description"].as_str().unwrap().contains("in 4 steps of one lock"), "{step}");
    assert_eq!(answer["steps"].as_array().unwrap().len(), 1, "{}", answer["steps"]);
}

#[test]
fn rows_of_one_lock_are_shifted_back() {
    let case = survey();
    // The fourth lock; its first reading is what came last before it.
    replace(&case, |n, read| read(if (58..76).contains(&n) { n - 1 } else { n }));
    let (step, _) = first(&case);
    assert_eq!(step["effect"], "input:row-shift");
    assert!(step["description"].as_str().unwrap().contains("in one lock"), "{step}");
}

#[test]
fn rows_of_every_lock_of_one_station_are_shifted_back() {
    let case = survey();
    // The second station's locks; the last reading of each has come first.
    let wrapped = |n: usize| if n.is_multiple_of(19) { n + 18 } else { n - 1 };
    replace(&case, |n, read| read(if (76..152).contains(&n) { wrapped(n) } else { n }));
    let (step, answer) = first(&case);
    assert_eq!(step["effect"], "input:row-shift");
    let said = step["description"].as_str().unwrap();
    assert!(said.contains("one row down in every lock of station `S2`"), "{step}");
    assert_eq!(answer["steps"].as_array().unwrap().len(), 1, "{}", answer["steps"]);
}

/// It lies so far off that nothing can be fitted.
#[test]
fn one_displacement_of_the_opposite_sign_is_named_with_its_line() {
    let case = survey();
    replace(&case, |n, read| if n == 70 { -read(n) } else { read(n) });
    let said = "the input looks wrong: -563.56183 of `displacement_mm` in line 72 of ranges.csv (S1) has the \
                opposite sign: it should be 563.56183";
    assert_refused(&case, said);
}

/// Far from all others, and nothing can be fitted: no row of the few stations and reflectors is to blame.
#[test]
fn one_displacement_in_metres_is_named_with_its_line() {
    let case = survey();
    replace(&case, |n, read| read(n) * if n == 70 { 1e-3 } else { 1.0 });
    let said = "the input looks wrong: 0.56356183 of `displacement_mm` in line 72 of ranges.csv (S1) has its decimal \
                point in another place: it should be 563.56183";
    assert_refused(&case, said);
}

#[test]
fn displacements_of_the_opposite_sign_from_a_line_to_a_line_are_named() {
    let case = survey();
    replace(&case, |n, read| if (5..32).contains(&n) { -read(n) } else { read(n) });
    let said = "`displacement_mm` of ranges.csv is of the opposite sign from line 7 to line 33: multiply by -1 there";
    assert_refused(&case, said);
}

/// In the first step every reflector stands where the angle is zero, as often as at any other angle.
#[test]
fn zeros_that_are_one_of_the_angles_are_not_missing() {
    let case = survey();
    // The third station begins with what came last before it.
    let third = |n: usize| (152..228).contains(&n);
    replace(&case, |n, read| read(if third(n) && n > 152 { n - 1 } else { n }));
    let ended = case.run("loop");
    assert!(!ended.stderr.contains("written as zeros"), "{}", ended.stderr);
    assert!(!ended.stdout.contains("written as zeros"), "{}", ended.stdout);
    assert!((ended.stderr + &ended.stdout).contains("shifted one row down"));
}

/// The reflectors of one station under each other's names, in a circle: nothing can be fitted.
#[test]
fn reflectors_of_one_station_are_given_their_names_back() {
    let files = ["case.toml", "stations.csv", "mounts.csv", RANGES];
    let case = fixture("tracker-lm/backlash", &files);
    change(&case, RANGES, &["station", "mount"], |n, old| {
        let [station, mount] = [&old[n][0], &old[n][1]];
        let other = match &**mount {
            "R1" => "R2",
            "R2" => "R3",
            "R3" => "R1",
            rest => rest,
        };
        vec![station.clone(), if station == "S3" { other.to_owned() } else { mount.clone() }]
    });
    let ended = case.run("loop");
    assert_eq!(ended.code, 3, "{}", ended.stdout);
    for said in ["where `station` is `S3`", "`R2` to `R1`", "`R3` to `R2`", "`R1` to `R3`"] {
        assert!(ended.stderr.contains(said), "{}", ended.stderr);
    }
}

#[test]
fn displacements_of_one_station_as_differences_are_added_up() {
    let case = survey();
    // The second station's locks; the first reading of each stands.
    let is_difference = |n: usize| (76..152).contains(&n) && !n.is_multiple_of(19);
    replace(&case, |n, read| if is_difference(n) { read(n) - read(n - 1) } else { read(n) });
    let ended = case.run("loop");
    let said = format!("{}{}", ended.stdout, ended.stderr);
    assert!(said.contains("each row a difference") && said.contains("is `S2`"), "{said}");
}

#[test]
fn readings_of_one_station_that_clip_or_are_of_both_ways_are_named_with_it() {
    let of_second = |n: usize| (76..152).contains(&n);
    let case = survey();
    // A quarter of its readings; those of other stations go on.
    replace(&case, |n, read| if of_second(n) { read(n).min(740.0) } else { read(n) });
    let ended = case.run("loop");
    let said = format!("{}{}", ended.stdout, ended.stderr);
    assert!(said.contains("where `station` is `S2`") && said.contains("clip"), "{said}");
    let case = survey();
    replace(&case, |n, read| if of_second(n) { 2.0 * read(n) } else { read(n) });
    let ended = case.run("loop");
    let said = format!("{}{}", ended.stdout, ended.stderr);
    assert!(said.contains("`station` is `S2`: multiply these by 0.5"), "{said}");
}

/// The files of two locks on one reflector under each other's names.
#[test]
fn stations_of_one_reflector_are_given_their_names_back() {
    let case = survey();
    // The third lock of the first and of the second station.
    let other = |n: usize| match n {
        38..57 => n + 76,
        114..133 => n - 76,
        _ => n,
    };
    replace(&case, |n, read| read(other(n)));
    let ended = case.run("loop");
    let said = format!("{}{}", ended.stdout, ended.stderr);
    assert!(said.contains("where `mount` is `R3`") && said.contains("`S2` to `S1`"), "{said}");
}

#[test]
fn one_station_in_a_mirrored_frame_is_named() {
    let case = fixture(
        "tracker-lm/targets-nothing",
        &["case.toml", "stations.csv", "mounts.csv", "targets.csv"],
    );
    change(&case, "targets.csv", &["station", "y_mm"], |n, old| {
        let [station, y] = [&old[n][0], &old[n][1]];
        let y: f64 = y.parse().unwrap();
        vec![station.clone(), format!("{}", if station == "S2" { -y } else { y })]
    });
    let said = case.message("loop", 3);
    let named = "the input looks wrong: `x_mm`, `y_mm`, `z_mm` of targets.csv are of the opposite sign where `station` \
                 is `S2`";
    assert!(said.contains(named) && said.contains("or: `y_mm` of targets.csv is"), "{said}");
}

/// Of four stations none can be left out: what is wrong with one row of them is tried itself.
#[test]
fn coordinates_of_one_station_that_are_exchanged_are_named_with_its_line() {
    let case = survey();
    change(&case, "stations.csv", &["y_mm", "z_mm"], |n, old| {
        let [y, z] = [old[n][0].clone(), old[n][1].clone()];
        if n == 1 { vec![z, y] } else { vec![y, z] }
    });
    let (step, _) = first(&case);
    assert_eq!(step["effect"], "input:exchanged", "{step}");
    let said = step["description"].as_str().unwrap();
    assert!(said.contains("`y_mm`, `z_mm` of stations.csv are exchanged"), "{said}");
    assert!(said.contains("in line 3"), "{said}");
}

/// A survey of a short swing, of stations above it that are known to some mm: with more than they are off the frame is
/// turned, and what is far from them is elsewhere. The readings agree, and nothing is wrong with any.
#[test]
fn stations_that_are_known_to_some_mm_accuse_no_reading() {
    const STATIONS_MM: [[f64; 3]; 5] = [
        [-500.0, -500.0, 1500.0],
        [520.0, -450.0, 1600.0],
        [450.0, 560.0, 1550.0],
        [-480.0, 520.0, 1700.0],
        [0.0, 60.0, 1800.0],
    ];
    const OFF_MM: [[f64; 3]; 5] = [
        [2.9, -1.4, 3.1],
        [-3.6, 2.2, -1.1],
        [1.8, 3.9, -2.7],
        [-2.4, -3.3, 1.2],
        [3.0, 1.0, -3.8],
    ];
    const MOUNTS_MM: [[f64; 3]; 4] =
        [[0.0, 0.0, 180.0], [110.0, 60.0, 160.0], [-120.0, 50.0, 150.0], [10.0, -120.0, 140.0]];
    const ORIGIN_Z_MM: f64 = 300.0;
    let toml = "kind = \"tracker-lm\"\n[axis]\nletter = \"B\"\norigin_mm = [0.0, 0.0, 300.0]\n\
                direction = [0.0, 1.0, 0.0]\n[noise]\ndisplacement_mm = 0.0005\n";
    let [mut stations, mut mounts, mut ranges] = [
        "station,x_mm,y_mm,z_mm\n",
        "mount,x_mm,y_mm,z_mm\n",
        "station,mount,step,angle_deg,displacement_mm\n",
    ]
    .map(str::to_owned);
    for (k, [x, y, z]) in MOUNTS_MM.into_iter().enumerate() {
        mounts += &format!("M{k},{x},{y},{z}\n");
    }
    let mut n = 0.0;
    for (i, (nominal, off)) in STATIONS_MM.into_iter().zip(OFF_MM).enumerate() {
        let [x, y, z] = nominal;
        stations += &format!("S{i},{x},{y},{z}\n");
        let station: [f64; 3] = std::array::from_fn(|axis| nominal[axis] + off[axis]);
        for (k, [x, y, z]) in MOUNTS_MM.into_iter().enumerate() {
            let length_mm = |angle_deg: f64| {
                let (sin, cos) = angle_deg.to_radians().sin_cos();
                let at = [x * cos + z * sin, y, ORIGIN_Z_MM - x * sin + z * cos];
                at.iter().zip(station).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
            };
            for step in 0..15 {
                let angle_deg = -21.0 + 3.0 * f64::from(step);
                n += 1.0;
                let noise_mm = 7e-4 * (1e4 * f64::sin(12.9 * n)).sin();
                let moved_mm = length_mm(angle_deg) - length_mm(-21.0) + noise_mm;
                ranges += &format!("S{i},M{k},{step},{angle_deg},{moved_mm:.6}\n");
            }
        }
    }
    let case = Case::new(&[
        ("case.toml", toml),
        ("stations.csv", &stations),
        ("mounts.csv", &mounts),
        (RANGES, &ranges),
    ]);
    let answer = case.json("loop");
    assert_eq!(answer["verdict"], "nothing-missing", "{}", answer["steps"]);
}
