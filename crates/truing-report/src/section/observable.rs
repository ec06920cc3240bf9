//! Effects that the design cannot see, and why.

use super::{Cell, Context, Kind, paragraph, table};
use crate::markup::Markup;
use crate::names::shortened;

pub(crate) fn observable(out: &mut Markup, context: &Context) {
    let Some(closure) = context.closure else {
        return;
    };
    out.element("h2", &[], "What these data cannot show");
    if closure.not_observable.is_empty() {
        paragraph(out, "", "Every candidate would have left a trace.");
        return;
    }
    paragraph(
        out,
        "",
        "These effects may be there: whatever they do, the declared model takes it up in the \
         parameters named.",
    );
    table(
        out,
        "Effects that cannot be seen",
        &[
            ("effect", Kind::Name),
            ("taken up by", Kind::Words),
            ("would become visible", Kind::Words),
        ],
        closure.not_observable.iter().map(|effect| {
            let by = effect.separate_by.as_deref();
            vec![
                Cell::new(&effect.effect),
                Cell::new(shortened(&effect.aliased_with)),
                Cell::new(by.unwrap_or("no measurement known to this kind of case")),
            ]
        }),
    );
}
