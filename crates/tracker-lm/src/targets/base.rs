//! Base parameters of the declared model beside those that are taken out of its rows.

use least_squares::{BorderedPoint, BorderedProblem};
use model_discrepancy::Parameter;

use super::HoldOut;
use super::bundle::Bundle;
use super::sight::Sight;
use crate::AxisModel;
use crate::curves::{Curves, LOCATION};
use crate::joint::location_name;

/// Derivative of a component of a reading by a base parameter.
pub(super) type ByBase<'a> = Box<dyn Fn(&Sight, usize, usize, usize) -> f64 + 'a>;

/// Base parameters beside those that are taken out, and the derivatives by them.
///
/// Where reflectors are free, the first station holds the frame; else the fit of the reflectors.
pub(super) fn base<'a>(
    bundle: &'a Bundle<'_>,
    point: &BorderedPoint,
    hold_out: HoldOut,
) -> (Vec<Parameter>, ByBase<'a>) {
    let survey = bundle.survey;
    let named = |name: String| {
        let (name, unit) = name.rsplit_once(" (").unwrap_or((&name, "mm)"));
        let unit = unit.trim_end_matches(')');
        Parameter { name: name.to_owned(), unit: unit.to_owned(), report_factor: 1.0 }
    };
    let of_station = move |sight: &Sight, n: usize, c: usize, p: usize| {
        let is_own = survey.targets[n].station == p / 6;
        if is_own { sight.by_station[(c, p % 6)] } else { 0.0 }
    };
    match hold_out {
        HoldOut::Step => {
            let (first, located) = (bundle.mount_start(), bundle.curve_start());
            let fitted = &point.shared[located..bundle.extra_start()];
            let at: Vec<_> =
                (0..bundle.angles.len()).map(|k| bundle.curves.at(k, fitted).slopes).collect();
            let names = (0..bundle.extra_start()).map(|p| named(bundle.shared_name(p))).collect();
            let by_base: ByBase<'a> = Box::new(move |sight, n, c, p| {
                if p < first {
                    return of_station(sight, n, c, p);
                }
                if p >= located {
                    let k = bundle.angle_of_step[survey.targets[n].step];
                    return (sight.by_error.row(c) * at[k][p - located])[0];
                }
                let moves = bundle.chart.moves(survey.targets[n].mount);
                let way = moves.iter().find(|(q, _)| *q == p - first);
                way.map_or(0.0, |(_, way)| (sight.by_mount.row(c) * way)[0])
            });
            (names, by_base)
        }
        HoldOut::Mount if bundle.axis_model != AxisModel::Free => {
            // Reflectors are free, and so are the trackers along and about the axis: the first one
            // holds its place beside an axis whose location is fitted.
            let stations = bundle.mount_start() - 6;
            let letter = survey.axis.letter;
            let station_names = (0..stations).map(|p| bundle.shared_name(p + 6));
            let location_names = (0..LOCATION.len()).map(|c| location_name(letter, c));
            let names = station_names.chain(location_names).map(named).collect();
            let location = Curves::new(&survey.axis, &bundle.angles_rad(), LOCATION.to_vec());
            let zero = [0.0; LOCATION.len()];
            let at: Vec<_> =
                (0..bundle.angles.len()).map(|k| location.at(k, &zero).slopes).collect();
            let by_base: ByBase<'a> = Box::new(move |sight, n, c, p| {
                if p < stations {
                    return of_station(sight, n, c, p + 6);
                }
                let k = bundle.angle_of_step[survey.targets[n].step];
                (sight.by_error.row(c) * at[k][p - stations])[0]
            });
            (names, by_base)
        }
        HoldOut::Mount => {
            let stations = bundle.mount_start() - 6;
            let n_errors = 6 * (bundle.angles.len() - 1);
            let station_names = (0..stations).map(|p| bundle.shared_name(p + 6));
            let error_names = (0..n_errors).map(|p| bundle.block_name(1 + p / 6, p % 6));
            let names = station_names.chain(error_names).map(named).collect();
            let by_base: ByBase<'a> = Box::new(move |sight, n, c, p| {
                if p < stations {
                    return of_station(sight, n, c, p + 6);
                }
                let p = p - stations;
                let is_own = bundle.angle_of_step[survey.targets[n].step] == 1 + p / 6;
                if is_own { sight.by_error[(c, p % 6)] } else { 0.0 }
            });
            (names, by_base)
        }
    }
}
