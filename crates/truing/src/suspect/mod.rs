//! Mistakes in the input: looked for before any physics.
//!
//! A kind lists what may be wrong with its own input as exact changes to what was read: a column
//! in another unit, two columns exchanged, rows one further down. Each is refitted in full. One
//! that takes a misfit as large as the thing measured down to the noise is named; it has no free
//! parameter, so what no exact change mends is left to the physics. A mistake beside physics is found
//! by closing the loop on the case so mended; the loop of the case itself is closed once.

mod channel;
mod clock;
mod coarse;
mod declared;
mod every_table;
mod examine;
mod factor;
mod held;
mod hypothesis;
mod increments;
mod jitter;
mod label;
mod late;
mod left_out;
mod misfit;
mod named;
mod odd;
mod order;
mod physics;
mod polar;
mod readings;
mod record;
mod refused;
mod rounded;
mod search;
mod setting;
mod sign;
mod slip;
mod some_rows;
mod spike;
mod stretch;
mod thinned;
mod typed;
mod unit;
mod unit_length;
mod written;
mod wrong_rows;
mod yardstick;
mod zeros;

pub(crate) use channel::{
    at_end, channels, clipped_of_few, clipped_of_one, place_standing_still, rows_left_out, silent,
    standing_still, standing_still_in_several, standing_still_within,
};
pub(crate) use clock::{clocks, stretches};
pub(crate) use coarse::{coarser_than_others, step_of};
pub(crate) use examine::{Examined, examine};
pub(crate) use held::held;
pub(crate) use hypothesis::{Hypothesis, Proof, lines_of, stretches_of};
pub(crate) use increments::increments;
pub(crate) use label::{
    Label, Part, labelled, labels_of, of_another_part, readings_of_each, readings_of_one,
};
pub use named::Suspect;
pub(crate) use odd::median;
pub(crate) use order::{
    blocks_shifted, copies, cycles, exchanged_blocks, exchanged_deviations, exchanged_rows,
    exchanged_targets, exchanges, farthest, names_of_one_exchanged, rows_shifted, rows_shifted_by,
    sorted_as_text, swapped_names,
};
pub(crate) use polar::polar;
pub(crate) use readings::{Readings, Samples, Set};
pub(crate) use record::Record;
pub(crate) use refused::named_cause;
pub(crate) use setting::{Typed, lengths, number, numbers, other_setting, scaled_setting};
pub(crate) use sign::{minus_lost, signs};
pub(crate) use slip::{points_lost, slip_of_sign};
pub(crate) use some_rows::axes_of_row;
pub(crate) use spike::spikes;
pub(crate) use unit::{Dimension, Twice, all_in_metres, doubled, units, units_from_a_row};
pub(crate) use unit_length::component_shifted;
pub(crate) use yardstick::{Yardstick, spread_of, spread_of_places};
pub(crate) use zeros::zeros;
