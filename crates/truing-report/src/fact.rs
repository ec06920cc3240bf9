/// One line of a table of facts.
#[derive(Clone, Debug, PartialEq)]
pub struct Fact {
    /// What it is.
    pub name: String,
    /// Its value with its unit, ready to read.
    pub value: String,
}
