//! PSI's tables on rooms of ours: where bodies come from, how they are fitted, what is measured of them.
//!
//! Table 1 (representation), Table 2 (diversity) and Table 3 (physics) of the paper, §4.1.3 and §4.1.4, for random
//! placement, the search and the networks, before fitting, after the published fit and after ours. Pure: rooms,
//! views and networks come in, rows go out ([`Evaluation`]); may not read or write files. The same seed gives the
//! same rows, whatever the number of threads.

mod placers;
mod rows;
mod run;
mod tables;

pub use placers::{LearnedPlacement, PlaceRequest, Placer, RandomPlacement, SearchPlacement};
pub use rows::{Evaluation, MethodRepresentation, MethodRow, Missing, PhysicalRow, RepresentationRow, Stage};
pub use run::{Encoded, EvaluationConfig, EvaluationRoom, Evaluator, Example, MethodToEvaluate, Representer};
