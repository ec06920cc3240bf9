//! DESI: pinholes on the focal plane, seen by the fibre view camera, beside metrology.

use std::fmt::Write as _;
use std::path::Path;

use anyhow::{Context, Result};

use super::{Case, Set};

/// Camera pixels are given in units of 15 µm about the middle of 6000 of them.
const PIXEL_MM: f64 = 0.015;
const MIDDLE_PIXEL: f64 = 3000.0;

pub(super) const SET: Set = Set {
    name: "desi-spots",
    source: "github.com/desihub/desimeter, commit 3ef70cff20d1, py/desimeter/test/data/test-spots.csv, BSD-3-Clause",
    licence: "BSD-3-Clause, the DESI collaboration; fixtures/licences/desimeter.rst",
    place: "desi_fvc_fiducials/test-spots.csv",
    reference: "3284 µm affine, 326 radial, 39.8 cubic, 27.1 in the end",
    left_out: "fiducial body of four pinholes",
    convert,
};

fn convert(file: &Path) -> Result<Vec<Case>> {
    let mut reader = csv::Reader::from_path(file)?;
    let names = reader.headers()?.clone();
    let column = |name: &str| {
        names.iter().position(|n| n == name).with_context(|| format!("no column {name}"))
    };
    let at = ["XPIX", "YPIX", "X_FP_METRO", "Y_FP_METRO"].map(column);
    let [x, y, to_x, to_y] = at;
    let (x, y, to_x, to_y) = (x?, y?, to_x?, to_y?);
    let (body, pinhole) = (column("LOCATION")?, column("PINHOLE_ID")?);
    let mut table = "point,from_x_mm,from_y_mm,to_x_mm,to_y_mm,fiducial\n".to_owned();
    let (mut kept, mut unmatched) = (0, 0);
    for record in reader.records() {
        let record = record?;
        let row = kept + unmatched + 1;
        let number = |column: usize| -> Result<f64> {
            record[column].parse().with_context(|| format!("row {row}"))
        };
        // A spot that no pinhole was found for has zeros for metrology.
        if number(to_x)? == 0.0 && number(to_y)? == 0.0 {
            unmatched += 1;
            continue;
        }
        kept += 1;
        let from = [number(x)?, number(y)?].map(|p| (p - MIDDLE_PIXEL) * PIXEL_MM);
        // A string takes every character.
        let _ = writeln!(
            table,
            "{}_{}_{kept},{:.6},{:.6},{},{},F{}",
            &record[body],
            &record[pinhole],
            from[0],
            from[1],
            &record[to_x],
            &record[to_y],
            &record[body]
        );
    }
    let settings = "kind = \"frame-fit\"\n\n[model]\ntransform = \"similarity\"\n\
                    handedness = \"improper\"   # the camera looks from the front\n\n\
                    [loop]\ngroup = \"fiducial\"\n";
    Ok(vec![Case {
        name: "spots".to_owned(),
        settings: settings.to_owned(),
        tables: vec![("pairs.csv", table)],
        notes: vec![format!("{kept} spots; {unmatched} without metrology left out")],
        carry: None,
    }])
}
