//! What people do in a scene, as the centre of the scene-aware estimator's prior (PSI §4.2, θ_s): from the search's
//! people of the whole room, or a network's samples of what one camera sees.

use clap::ValueEnum;

use crate::generate::sensor::{Sensor, View};
use crate::job::{Seed, Stop, Ticker};
use crate::learn::estimation::scene_code_by_search;
use crate::scene::{POSE, Room};

/// Who says what people do in a scene.
#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum PriorSource {
    /// The affordance search, for the whole room.
    Search,
}

impl PriorSource {
    /// Name in reports.
    pub fn label(self) -> &'static str {
        match self {
            Self::Search => "search",
        }
    }
}

/// Ready to be asked about views of one room.
pub enum ScenePrior {
    /// One code for every view.
    Same([f32; POSE]),
}

impl ScenePrior {
    /// For one room.
    ///
    /// # Errors
    /// When the source is not there; [`Stop::Cancelled`] once the user cancelled.
    pub fn new(
        source: PriorSource,
        room: &Room,
        sensor: &Sensor<'_>,
        seed: Seed,
        ticker: &Ticker,
    ) -> Result<Self, Stop> {
        match source {
            PriorSource::Search => {
                Ok(Self::Same(scene_code_by_search(room, sensor.geometry(), seed, ticker)?))
            }
        }
    }

    /// The mean pose code of people whom this view could show; `number` chooses the samples.
    pub fn code(&self, _view: &View, _number: u64) -> [f32; POSE] {
        match self {
            Self::Same(code) => *code,
        }
    }
}
