//! Measurements that would tell the effects of a log apart.

use model_discrepancy::Proposal;

use crate::missing::log_blocks::Block;
use crate::missing::log_model::LogModel;

/// Blocks of a proposed run: one for each of a handful of places along the log.
const N_BLOCKS: usize = 24;

/// The cheapest first.
pub(crate) fn proposals(model: &LogModel) -> Vec<Proposal<'_>> {
    if !model.has_reference {
        return vec![Proposal::new(
            "record the contact force with a reference instrument beside the legs",
            || Some(with_reference(model)),
        )];
    }
    vec![
        proposal(model, "record a while with the head hanging free, then go on", |b, _| {
            b.sensitivity.of_cell_n = b.sensitivity.of_cell_n.map(|_| 0.0);
            b.sensitivity.tangential_n = 0.0;
            b.normal_n = 0.0;
        }),
        proposal(model, "repeat the run at twice the contact force", |b, _| {
            b.sensitivity.of_cell_n = b.sensitivity.of_cell_n.map(|f| 2.0 * f);
            b.sensitivity.tangential_n *= 2.0;
            b.normal_n *= 2.0;
        }),
        proposal(model, "let the axial unit travel in and out at constant force", |b, i| {
            let way = if i % 2 == 0 { 1.0 } else { -1.0 };
            b.slide = way;
            b.slide_normal = way * b.sensitivity.axial_share;
        }),
        proposal(model, "repeat the run once more, later", |b, i| {
            b.elapsed_share = 1.0 + crate::count(i) / crate::count(N_BLOCKS);
        }),
    ]
}

fn proposal<'a>(
    model: &'a LogModel,
    text: &str,
    change: impl Fn(&mut Block, usize) + 'a,
) -> Proposal<'a> {
    Proposal::new(text, move || Some(extended(model, &change)))
}

/// The log with more blocks like those it has, changed.
fn extended(model: &LogModel, change: impl Fn(&mut Block, usize)) -> LogModel {
    let mut more = model.clone();
    let step = model.blocks.len().div_ceil(N_BLOCKS).max(1);
    let added = model.blocks.iter().step_by(step).enumerate().map(|(i, block)| {
        let mut block = block.clone();
        change(&mut block, i);
        block
    });
    more.add_blocks(added.collect());
    more.shown_anew()
}

/// The same run with a reference: its forces, not its lengths, are judged.
fn with_reference(model: &LogModel) -> LogModel {
    let mut with = model.clone();
    with.has_reference = true;
    "N".clone_into(&mut with.declared.layout.unit);
    with
}
