//! Registration of clouds.

mod consistency;
mod degenerate;
mod freedoms;
mod laws;
mod nearest;
mod neighbourhoods;
mod outliers;
mod scene;
mod starts;
