//! What people do in a scene, as the centre of the scene-aware estimator's prior (PSI §4.2, θ_s): the mean pose code of
//! a network's samples of what one camera sees, or of the search's people of the whole room.

use std::path::Path;

use clap::ValueEnum;

use super::network::Network;
use crate::generate::learned::LearnedSampler;
use crate::generate::sensor::{SceneImage, Sensor};
use crate::job::{Seed, Stop, Ticker};
use crate::learn::estimation::{SCENE_SAMPLES, scene_code_by_search};
use crate::nn::psi::PsiMethod;
use crate::scene::{POSE, Room};

/// Who says what people do in a scene.
#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum PriorSource {
    /// The one-stage network of PSI, as in the paper: from what the camera sees.
    S1,
    /// The affordance search, for the whole room.
    Search,
}

impl PriorSource {
    /// Name in reports.
    pub fn label(self) -> &'static str {
        match self {
            Self::S1 => "s1",
            Self::Search => "search",
        }
    }
}

/// Somebody who knows what people do in scenes.
pub enum ScenePrior {
    /// The affordance search.
    Search,
    /// A network of what a camera sees.
    Network(Network),
}

impl ScenePrior {
    /// The source that was asked for; `weights` stand in for those that come with the program.
    ///
    /// # Errors
    /// When no weights are there or the file can't be used.
    pub fn of(source: PriorSource, weights: Option<&Path>) -> anyhow::Result<Self> {
        if source == PriorSource::Search {
            return Ok(Self::Search);
        }
        Ok(Self::Network(Network::of(PsiMethod::S1, weights)?))
    }

    /// Ready to be asked about views of one room.
    ///
    /// # Errors
    /// [`Stop::Cancelled`] once the user cancelled.
    pub fn in_room(
        &self,
        room: &Room,
        sensor: &Sensor<'_>,
        seed: Seed,
        ticker: &Ticker,
    ) -> Result<RoomPrior<'_>, Stop> {
        Ok(match self {
            Self::Search => RoomPrior::Same(scene_code_by_search(room, sensor.geometry(), seed, ticker)?),
            Self::Network(network) => RoomPrior::OfView(network, seed),
        })
    }
}

/// A [`ScenePrior`] in one room.
pub enum RoomPrior<'a> {
    /// One code for every view.
    Same([f32; POSE]),
    /// Samples of each view.
    OfView(&'a LearnedSampler, Seed),
}

impl RoomPrior<'_> {
    /// The mean pose code of people in what a camera sees; `number` chooses the samples.
    pub fn code(&self, image: &SceneImage, number: u64) -> [f32; POSE] {
        match self {
            Self::Same(code) => *code,
            Self::OfView(network, seed) => {
                network.mean_pose_code(image, SCENE_SAMPLES, seed.child("view", number))
            }
        }
    }
}
