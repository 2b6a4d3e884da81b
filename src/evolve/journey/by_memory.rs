//! Legs by retrieval: the same two ends and the same way as for the gait, told in the memory's terms.

use glam::Vec3;

use super::Cast;
use crate::job::{Stop, Ticker};
use crate::motion::gait;
use crate::motion::learned::LegEnds;
use crate::motion::leg::{EndState, LegInput, LegMotion};
use crate::scene::{Frame, direction_of};

/// The leg from the request's memory of clips.
pub(super) fn leg(cast: &Cast<'_>, input: &LegInput, ticker: &Ticker) -> Result<LegMotion, Stop> {
    let [from, to] = [&input.from, &input.to].map(|state| frame(cast, input, state));
    let floor_m = input.path.first().map_or(0.0, |p| p.at.y);
    let ends = LegEnds { betas: &input.betas, from: &from, to: &to, floor_m, seconds: input.seconds };
    let velocities = [&input.from, &input.to].map(|state| Some(velocity(state)));
    let made = match &cast.request.memory {
        Some(memory) => memory.leg(cast.body, &ends, velocities, &input.path, ticker)?,
        None => None,
    };
    let Some(mut made) = made else {
        return Err(Stop::Failed(
            "the method `retrieval` needs motion clips: name a folder of them, or use `gait`".to_owned(),
        ));
    };
    // Legs meet in the very same frame.
    if let [first, .., last] = made.frames.as_mut_slice() {
        (*first, *last) = (from, to);
    }
    Ok(made)
}

fn frame(cast: &Cast<'_>, input: &LegInput, state: &EndState) -> Frame {
    match state {
        EndState::Still(still) => still.frame.clone(),
        EndState::Walking(walking) => gait::walking_frame(cast.body, &input.betas, walking),
    }
}

/// Velocity of the pelvis, metres per second.
fn velocity(state: &EndState) -> Vec3 {
    match state {
        EndState::Still(_) => Vec3::ZERO,
        EndState::Walking(walking) => {
            let ahead = direction_of(walking.heading) * walking.speed_m_per_s;
            Vec3::new(ahead.x, 0.0, ahead.y)
        }
    }
}
