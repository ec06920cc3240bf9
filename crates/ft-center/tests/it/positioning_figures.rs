//! Figures of ISO 230-2 against published runs and by laws.

use ft_center::{Approach, AxisFigures, AxisReading, axis_figures};

/// A published run: targets, then positions of five cycles at each, rising and falling, mm.
struct Published {
    targets: [f64; 5],
    rising: [[f64; 5]; 5],
    falling: [[f64; 5]; 5],
}

/// `github.com/paulscherrerinstitute/ecmccfg`, commit 2e51e0eaf6a2, `examples/mcu1025_fat_sat/report.md`.
const STAGE: Published = Published {
    targets: [15.0, 25.2, 35.4, 45.6, 55.8],
    rising: [
        [15.0033, 15.00452, 15.00085, 15.0033, 15.00595],
        [25.19933, 25.19913, 25.19933, 25.20015, 25.20117],
        [35.38477, 35.38762, 35.38395, 35.3864, 35.3866],
        [45.59182, 45.58978, 45.59263, 45.59263, 45.5908],
        [55.83882, 55.84025, 55.83964, 55.84086, 55.84005],
    ],
    falling: [
        [15.10035, 14.9721, 14.9721, 14.96966, 14.97251],
        [25.27803, 25.2132, 25.21259, 25.21748, 25.21422],
        [35.39639, 35.38803, 35.38926, 35.39252, 35.3915],
        [45.57387, 45.57041, 45.5649, 45.56939, 45.57061],
        [55.79315, 55.79499, 55.79132, 55.79193, 55.7958],
    ],
};

/// `github.com/anderssandstrom/ecmc_target_muts_logger`, commit 61b551aa5803,
/// `muts/data/week42_22/xyz/target_x_report_8A.md`.
const TARGET: Published = Published {
    targets: [-4.0, -2.0, 0.0, 2.0, 4.0],
    rising: [
        [-3.99861, -3.98366, -3.98366, -3.95012, -3.95335],
        [-2.00655, -1.98836, -1.98109, -1.9419, -1.93341],
        [-0.02782, -0.00802, -0.01005, 0.01986, 0.0344],
        [1.97474, 1.99616, 2.00181, 2.03495, 2.04909],
        [4.00316, 4.00397, 4.00963, 4.03024, 4.05165],
    ],
    falling: [
        [-4.10205, -4.01598, -3.99861, -3.99254, -3.96143],
        [-2.11969, -2.02392, -2.00251, -1.99968, -1.9617],
        [-0.13005, -0.02904, -0.01489, -0.01126, 0.01622],
        [1.94767, 1.97191, 1.98848, 2.00949, 2.02323],
        [3.94983, 3.98054, 3.98538, 4.01731, 4.03024],
    ],
};

fn readings(run: &Published) -> Vec<AxisReading> {
    let mut all = Vec::new();
    for cycle in 0..5 {
        for (approach, table) in [(Approach::Rising, run.rising), (Approach::Falling, run.falling)]
        {
            for (target, positions) in run.targets.iter().zip(table) {
                all.push(AxisReading {
                    name: format!("{target} {cycle} {approach:?}"),
                    target: *target,
                    deviation: positions[cycle] - target,
                    approach: Some(approach),
                });
            }
        }
    }
    all
}

fn value(found: &AxisFigures, symbol: &str) -> f64 {
    let figure = found.figures.iter().find(|f| f.symbol == symbol).expect("a figure of that name");
    figure.value.expect("a value")
}

/// What the reports print, rounded to 10 nm; sums of up to eight of such roundings.
const PRINTED_MM: f64 = 4e-5;

#[test]
fn figures_are_those_of_two_published_runs() {
    // E is not as those reports print it (the larger of E↑ and E↓, and in the first the smaller): by
    // ISO 230-2:2014, 3.20, it is the range over both directions, here of the printed means.
    let stage = [
        ("A", 0.23036),
        ("A rising", 0.05853),
        ("A falling", 0.23036),
        ("E", 0.03993 + 0.03016),
        ("E rising", 0.05405),
        ("E falling", 0.05727),
        ("R", 0.23036),
        ("R rising", 0.00751),
        ("R falling", 0.23036),
        ("B", 0.04649),
        ("B mean", 0.00829),
        ("M", 0.036),
    ];
    let target = [
        ("A", 0.24337),
        ("A rising", 0.14139),
        ("A falling", 0.24337),
        ("E", 0.02974 + 0.0338),
        ("E rising", 0.02806),
        ("E falling", 0.02646),
        ("R", 0.23715),
        ("R rising", 0.12529),
        ("R falling", 0.23715),
        ("B", 0.05124),
        ("B mean", 0.03544),
        ("M", 0.02226),
    ];
    for (run, printed) in [(STAGE, stage), (TARGET, target)] {
        let found = axis_figures(&readings(&run), 0.0);
        for (symbol, expected) in printed {
            let got = value(&found, symbol);
            assert!((got - expected).abs() < PRINTED_MM, "{symbol}: {got}, printed {expected}");
        }
    }
    // By target, of the first: mean, reversal, standard deviations and R_i.
    let found = axis_figures(&readings(&STAGE), 0.0);
    let printed = [
        (0.00046, 0.00624, 0.00188, 0.05759, 0.23036),
        (0.01346, -0.02728, 0.00085, 0.02853, 0.11413),
        (-0.0113, -0.00567, 0.00148, 0.00324, 0.01511),
        (-0.01932, 0.02169, 0.00124, 0.00323, 0.03063),
        (0.01668, 0.04649, 0.00076, 0.00193, 0.05185),
    ];
    for (t, (mean, reversal, s_rising, s_falling, r)) in found.targets.iter().zip(printed) {
        let got = [
            t.mean(),
            t.reversal().unwrap(),
            t.rising.unwrap().std.unwrap(),
            t.falling.unwrap().std.unwrap(),
            t.repeatability().unwrap(),
        ];
        for (got, expected) in got.into_iter().zip([mean, reversal, s_rising, s_falling, r]) {
            assert!((got - expected).abs() < PRINTED_MM, "{}: {got}, {expected}", t.target);
        }
    }
}

#[test]
fn figures_by_hand() {
    // Two targets, two cycles: x̄↑ = 2, −1; x̄↓ = −2, 1; s = √2 and √8 rising, √2 and 0 falling.
    let table: [(f64, Approach, [f64; 2]); 4] = [
        (0.0, Approach::Rising, [1.0, 3.0]),
        (10.0, Approach::Rising, [-3.0, 1.0]),
        (10.0, Approach::Falling, [1.0, 1.0]),
        (0.0, Approach::Falling, [-3.0, -1.0]),
    ];
    let readings: Vec<AxisReading> = (0..2)
        .flat_map(|cycle| {
            table.map(|(target, approach, x)| AxisReading {
                name: format!("{target} {approach:?} {cycle}"),
                target,
                deviation: x[cycle],
                approach: Some(approach),
            })
        })
        .collect();
    let found = axis_figures(&readings, 0.1);
    let (root2, root8) = (2f64.sqrt(), 8f64.sqrt());
    for (symbol, by_hand) in [
        ("E rising", 3.0),
        ("E falling", 3.0),
        ("E", 4.0),
        ("B", 4.0),
        ("B mean", 1.0),
        ("M", 0.0),
        ("R rising", 4.0 * root8),
        ("R falling", 4.0 * root2),
        ("R", (2.0 * root8 + 2.0).max(4.0 * root8).max(4.0 * root2 + 4.0)),
        ("A rising", (2.0 + 2.0 * root2).max(-1.0 + 2.0 * root8) - (-1.0 - 2.0 * root8)),
        ("A falling", 1.0 - (-2.0 - 2.0 * root2)),
        ("A", (2.0 + 2.0 * root2) - (-1.0 - 2.0 * root8)),
    ] {
        let got = value(&found, symbol);
        assert!((got - by_hand).abs() < 1e-12, "{symbol}: {got}, by hand {by_hand}");
    }
    // Pooled variance (2 + 8 + 2 + 0)/4 = 3; two readings a mean; a length standard of 0.1·10.
    let std = |symbol: &str| {
        found.figures.iter().find(|f| f.symbol == symbol).and_then(|f| f.std).unwrap()
    };
    let (of_mean, of_std) = ((3.0f64 / 2.0).sqrt(), (3.0f64 / 2.0).sqrt());
    let apart = root2 * of_mean;
    assert!((std("E") - apart.hypot(1.0)).abs() < 1e-12);
    assert!((std("B") - apart).abs() < 1e-12);
    assert!((std("M") - of_mean.hypot(1.0)).abs() < 1e-12);
    assert!((std("R rising") - 4.0 * of_std).abs() < 1e-12);
}

#[test]
fn laws_of_the_figures() {
    let plain = readings(&TARGET);
    let of = |readings: &[AxisReading]| axis_figures(readings, 0.0);
    let agree = |a: f64, b: f64, what: &str| assert!((a - b).abs() < 1e-12, "{what}: {a}, {b}");
    let symbols: Vec<&str> = of(&plain).figures.iter().map(|f| f.symbol).collect();
    // A shift of all readings changes nothing but the means by target.
    let shifted: Vec<AxisReading> =
        plain.iter().map(|r| AxisReading { deviation: r.deviation + 0.7, ..r.clone() }).collect();
    // The cycles in another order change nothing at all.
    let mut reordered = plain.clone();
    reordered.rotate_left(10);
    reordered.reverse();
    for symbol in &symbols {
        agree(value(&of(&shifted), symbol), value(&of(&plain), symbol), symbol);
        agree(value(&of(&reordered), symbol), value(&of(&plain), symbol), symbol);
    }
    for (a, b) in of(&shifted).targets.iter().zip(of(&plain).targets) {
        agree(a.mean(), b.mean() + 0.7, "mean");
        agree(a.reversal().unwrap(), b.reversal().unwrap(), "reversal");
    }
    // The axis counted the other way: targets, deviations and directions change sign.
    let mirrored: Vec<AxisReading> = plain
        .iter()
        .map(|r| AxisReading {
            name: r.name.clone(),
            target: -r.target,
            deviation: -r.deviation,
            approach: r.approach.map(|a| match a {
                Approach::Rising => Approach::Falling,
                Approach::Falling => Approach::Rising,
            }),
        })
        .collect();
    for [a, b] in [
        ["A", "A"],
        ["E", "E"],
        ["R", "R"],
        ["B", "B"],
        ["B mean", "B mean"],
        ["M", "M"],
        ["A rising", "A falling"],
        ["E rising", "E falling"],
        ["R rising", "R falling"],
    ] {
        agree(value(&of(&mirrored), a), value(&of(&plain), b), a);
    }
    // One way alone has no bidirectional figure.
    let one_way: Vec<AxisReading> =
        plain.into_iter().filter(|r| r.approach == Some(Approach::Rising)).collect();
    for figure in of(&one_way).figures {
        let is_one_way = figure.symbol.ends_with("rising");
        assert_eq!(figure.value.is_some(), is_one_way, "{}", figure.symbol);
    }
}
