//! Simulated mirrors that are committed.

use crate::expectation::Expectation;
use crate::generators::noise::Colour;
use crate::generators::{Case, Story, generated, named_within, nothing, over_noise, words};
use crate::kinds::pose_icp::mirror::{Flaw, Mirror, Touched, simulate};

/// Error on check points over the noise of those points alone. A pose of 5 parameters and an
/// effect of 3 from 36 touches add 8/36 of the variance, 11 % in the root; twelve residuals scatter
/// by 20 % of what is added, three times which is allowed.
const HELD_OUT_AT_MOST: f64 = 1.35;

/// All of them.
pub(crate) fn cases() -> Vec<Case> {
    vec![
        nothing_white(),
        nothing_coloured(),
        astigmatism(),
        trefoil(),
        conic(),
        near_sphere(),
        machine_scale(),
        drift(),
        bad_point(),
        growth(),
        outside_rings(),
        outside_humidity(),
    ]
}

fn mirror_case(
    folder: &str,
    mirror: &Mirror,
    title: &'static str,
    truth: &str,
    expect: Expectation,
) -> Case {
    let Touched { case_toml, points_csv, edge_csv, check_noise_mm, .. } = simulate(mirror);
    let expect = over_noise(expect, check_noise_mm);
    let mut tables = vec![("case.toml", case_toml), ("points.csv", points_csv)];
    tables.extend(edge_csv.map(|text| ("edge.csv", text)));
    let truth = format!(
        "{truth} R = {} mm, k = {}, diameter {} mm; noise {} µm per coordinate.",
        mirror.radius_mm,
        mirror.conic,
        mirror.diameter_mm,
        mirror.noise_mm * 1e3
    );
    generated(&format!("pose-icp/{folder}"), mirror.seed, tables, Story { title, truth, expect })
}

/// The named effect, nothing else, and nearly nothing left on points never fitted.
fn named(class: &[&str]) -> Expectation {
    named_within(class, HELD_OUT_AT_MOST)
}

fn nothing_white() -> Case {
    let expect = nothing(&["nothing-missing"]);
    mirror_case("nothing-white", &Mirror::new(61), "Nothing wrong", "Nothing is wrong.", expect)
}

fn nothing_coloured() -> Case {
    let mirror = Mirror {
        colour: Colour::Ar1(0.7),
        record_air: true,
        declare_noise: false,
        ..Mirror::new(62)
    };
    let truth = "Nothing is wrong. Successive touches are correlated by 0.7; the air temperature \
                 wanders and drives nothing.";
    // That successive residuals resemble each other is all there is to say.
    let expect =
        Expectation { structure: vec![words(&["order"])], ..nothing(&["structure-remains"]) };
    mirror_case("nothing-coloured", &mirror, "Nothing wrong, coloured noise", truth, expect)
}

fn astigmatism() -> Case {
    let mirror = Mirror { flaw: Flaw::Astigmatism([0.006, -0.004]), ..Mirror::new(63) };
    let truth = "Clamped at two places, the mirror is bent like a saddle: 6 and −4 µm at the rim.";
    mirror_case("astigmatism", &mirror, "Mirror bent by its clamps", truth, named(&["astigmatism"]))
}

fn trefoil() -> Case {
    let mirror = Mirror { flaw: Flaw::Trefoil([-0.005, 0.006]), ..Mirror::new(64) };
    let truth = "Three supports print through: −5 and 6 µm at the rim.";
    mirror_case("trefoil", &mirror, "Three supports print through", truth, named(&["trefoil"]))
}

fn conic() -> Case {
    let mirror = Mirror { flaw: Flaw::Conic(0.12), ..Mirror::new(65) };
    let truth = "The mirror was figured to k = −0.88 instead of −1.";
    mirror_case("conic", &mirror, "Wrong conic constant", truth, named(&["conic"]))
}

fn near_sphere() -> Case {
    let mirror = Mirror {
        radius_mm: 60.0,
        conic: -0.02,
        diameter_mm: 80.0,
        flaw: Flaw::Tip(0.012),
        ..Mirror::new(66)
    };
    let truth = "The ball is 12 µm larger than declared. A ball on a sphere of radius R runs on a \
                 sphere of radius R − r: on this near-sphere that is a vertex radius 12 µm shorter, \
                 and only a measurement of either can tell.";
    let expect = Expectation {
        says: words(&["tip-radius", "vertex-radius", "calibrate the tip"]),
        ..named(&["tip-radius", "vertex-radius"])
    };
    mirror_case("near-sphere", &mirror, "Ball or radius, on a near-sphere", truth, expect)
}

fn machine_scale() -> Case {
    let mirror = Mirror {
        radius_mm: 60.0,
        diameter_mm: 80.0,
        flaw: Flaw::MachineScale([350e-6, 0.0, 0.0]),
        ..Mirror::new(67)
    };
    let truth = "The machine's x reads 350 ppm long.";
    mirror_case("machine-scale", &mirror, "Scale of one axis", truth, named(&["axis-scale"]))
}

fn drift() -> Case {
    let mirror = Mirror { flaw: Flaw::Drift(-0.008), ..Mirror::new(68) };
    let truth = "The spindle grows by 8 µm during the session (first-order warming, time constant \
                 twice the session), so not quite in proportion to time.";
    let expect = named(&["drift", "covariate:time_s"]);
    mirror_case("drift", &mirror, "Spindle grows", truth, expect)
}

fn bad_point() -> Case {
    let mirror = Mirror { flaw: Flaw::BadPoint(13, 0.015), ..Mirror::new(69) };
    let truth = "Touch P14 sits on a chip: 15 µm high.";
    let expect = Expectation { says: words(&["P14"]), ..named(&["bad-point"]) };
    mirror_case("bad-point", &mirror, "One touch on a chip", truth, expect)
}

fn growth() -> Case {
    let mirror = Mirror { record_air: true, flaw: Flaw::Growth(0.006), ..Mirror::new(70) };
    let truth = "The readings of z follow the air by 6 µm/K; the temperature is recorded.";
    mirror_case("temperature", &mirror, "Column follows the air", truth, named(&["temperature"]))
}

fn outside_rings() -> Case {
    let mirror = Mirror { n_points: 96, flaw: Flaw::Rings(0.004, 16.0), ..Mirror::new(71) };
    let truth = "A rotating tool left rings: 4 µm with a period of 16 mm along the radius, which no \
                 effect in the catalogue describes.";
    let expect = Expectation {
        verdict: words(&["structure-remains"]),
        nothing_else: true,
        empirical_allowed: true,
        structure: vec![words(&["part_radius_mm"])],
        ..Expectation::default()
    };
    mirror_case("outside-rings", &mirror, "Rings of a rotating tool", truth, expect)
}

fn outside_humidity() -> Case {
    let mirror = Mirror { flaw: Flaw::Humidity(0.0012), ..Mirror::new(72) };
    let truth = "The stylus of carbon fibre swells: 1.2 µm per percent of humidity along z. The \
                 humidity is recorded; the catalogue knows nothing of it.";
    let expect = named(&["covariate:humidity_pct"]);
    mirror_case("outside-humidity", &mirror, "Stylus swells with humidity", truth, expect)
}
