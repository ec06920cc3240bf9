//! What a page must hold whatever the data.

mod document;
mod form;
mod hostile;
mod index;
mod machine;
mod plots;
mod sample;
mod words;

use roxmltree::{Document, Node, ParsingOptions};

/// Parses a page as XML; panics where it is not well-formed.
fn parse(page: &str) -> Document<'_> {
    let options = ParsingOptions { allow_dtd: true, ..ParsingOptions::default() };
    Document::parse_with_options(page, options).unwrap_or_else(|e| panic!("not well-formed: {e}"))
}

/// All text within a node.
fn text_of(node: Node) -> String {
    node.descendants().filter(Node::is_text).filter_map(|n| n.text()).collect()
}

/// The section under a heading.
fn section<'a, 'input>(document: &'a Document<'input>, heading: &str) -> Node<'a, 'input> {
    let is_it = |n: &Node| {
        n.has_tag_name("section")
            && n.descendants().any(|c| c.has_tag_name("h2") && text_of(c) == heading)
    };
    document.descendants().find(is_it).unwrap_or_else(|| panic!("no section «{heading}»"))
}

fn has_class(node: Node, class: &str) -> bool {
    node.attribute("class").is_some_and(|c| c.split(' ').any(|word| word == class))
}
