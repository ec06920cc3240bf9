use std::fmt;

/// How much of an answer a text for people holds, and how wide it may be.
///
/// ```
/// use truing::{Detail, Layout};
///
/// let folder = std::env::temp_dir().join(format!("truing-layout-{}", std::process::id()));
/// truing::write_example("frame-fit", &folder)?;
/// let closed = truing::close_loop(&truing::read_case(&folder)?)?;
/// let narrow = closed.text(Layout { detail: Detail::Full, columns: Some(60) });
/// assert!(narrow.lines().all(|line| !line.starts_with("  P1") || line.chars().count() <= 60));
/// # std::fs::remove_dir_all(&folder).ok();
/// # Ok::<(), truing::Error>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Layout {
    /// How much.
    pub detail: Detail,
    /// Characters that a row of a table may have; wider ones go on below. `None`: any number.
    pub columns: Option<usize>,
}

/// How much of an answer is shown; the JSON has all of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Detail {
    /// The result in a few lines.
    Headline,
    /// And what it rests on, long tables cut short.
    #[default]
    Summary,
    /// And every step with its tests.
    Full,
}

impl Layout {
    /// Rows that are shown of a table.
    pub(crate) fn most_rows(self) -> usize {
        match self.detail {
            Detail::Headline => 0,
            Detail::Summary => 12,
            // One screen, and some.
            Detail::Full => 40,
        }
    }
}

/// What is written, as a string.
pub(crate) fn written(write: impl FnOnce(&mut String) -> fmt::Result) -> String {
    let mut text = String::new();
    write(&mut text).expect("a string takes everything");
    text
}
