//! Proposals of people for a room: what a camera sees of it ([`sensor`]), the networks that learned from such
//! pictures ([`learned`]), and affordance search over support
//! surfaces, heights, clearance and facing.
//!
//! May not name `fit` or `motion`, nor move vertices by gradient: what comes out is ranked starts for the
//! fitter. Deterministic for a given seed, whatever the number of threads.

pub mod learned;
pub mod sensor;

mod cells;
mod floor_places;
mod lie_places;
mod place;
mod pose;
mod search;
mod seat_places;

pub use cells::Cells;
pub use place::{Place, support_name};
pub use search::{Proposal, SearchRequest, all_places, search, settle_person};
pub use seat_places::seat_family;
