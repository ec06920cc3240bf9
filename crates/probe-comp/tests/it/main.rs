//! Public behaviour of `probe-comp`.

#![expect(clippy::unwrap_used, reason = "a helper that fails is a test that fails")]

mod consistency;
mod degenerate;
mod effects;
mod exact;
mod guide;
mod laws;
mod loops;
mod micro;
mod profile;
mod proposed;
mod qualified;
mod scene;
