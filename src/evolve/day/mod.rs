//! A day in a room: somebody goes from action to action (ADSE's chain, LTM's motion), does each for a while, and things
//! come, are moved and cleared away when they get there; all of it on one timeline.
//!
//! One person's day: what people do in groups is left out. A way is planned in the room as the action will leave it;
//! what the action is about to move may stand in it until then. The same request and seed give the same bytes. May not
//! name the document or a front end; says what could not be done instead of doing something else.

#[cfg(test)]
mod tests;
mod track;
mod walk;

pub use self::track::{Place, Track};
use self::walk::{At, Walker};
use crate::evolve::action::{ActionKind, Evolution, EvolutionConfig, embody_as};
use crate::evolve::journey::JourneyPreview;
use crate::job::{JobCtx, Stop};
use crate::scene::Clip;

/// Draws in a row that turn out impossible, or can't be walked to, before the day ends early.
const MOST_REFUSALS: u64 = 24;
/// Things take so long from where they were to where they are wanted, seconds.
pub const CHANGE_S: f32 = 1.0;

/// What is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DayRequest {
    /// How many actions.
    pub actions: usize,
    /// How long each is done, seconds.
    pub stay_s: f32,
    /// Whether the legs are fitted to the room; without, they are as they were made.
    pub optimise: bool,
}

impl Default for DayRequest {
    fn default() -> Self {
        Self { actions: 6, stay_s: 4.0, optimise: true }
    }
}

/// One action on the timeline.
#[derive(Clone, Debug, PartialEq)]
pub struct Moment {
    /// Number of its step, from 1: [`Day::states`] has the room after it at the same place.
    pub step: usize,
    /// "use laptop on desk while sitting".
    pub action: String,
    /// Name of the key object.
    pub key: String,
    /// When its things begin to change, seconds.
    pub changes_s: f32,
    /// When somebody is at it.
    pub arrives_s: f32,
    /// When they leave it.
    pub leaves_s: f32,
    /// Whether they walked there; else they turned to it where they sat.
    pub walked: bool,
}

/// A day.
#[derive(Clone)]
pub struct Day {
    /// The person's motion.
    pub clip: Clip,
    /// What was done when.
    pub moments: Vec<Moment>,
    /// The room before, and after each action.
    pub states: Vec<Evolution>,
    /// Actions that were drawn and could not be done or walked to, and why.
    pub refused: Vec<String>,
}

impl Day {
    /// The room's state at a time: changes count from when they begin.
    pub fn state_at(&self, seconds: f32) -> &Evolution {
        let begun = self.moments.iter().filter(|m| m.changes_s <= seconds).count();
        &self.states[begun.min(self.states.len() - 1)]
    }

    /// How things move and when they come, in the frames of [`Track::object`]'s geometry in the last state's room.
    pub fn tracks(&self) -> Vec<Track> {
        track::tracks(&self.states, &self.moments)
    }
}

/// Lets somebody live in the room for some actions. Previews are the day as far as it has come.
///
/// # Errors
/// [`Stop::Cancelled`] when the user cancelled; [`Stop::Failed`] when there is nowhere to stand, or no action can be
/// done and walked to. A day that ends early says why in [`Day::refused`].
pub fn day(start: &Evolution, request: &DayRequest, cx: &JobCtx<Day>) -> Result<Day, Stop> {
    let start = alone(start);
    cx.stage("from action to action", request.actions)?;
    let mut walker = Walker::new(&start, request, cx)?;
    let mut day = Day { clip: walker.clip(), moments: Vec::new(), states: vec![start], refused: Vec::new() };
    let mut refusals = 0;
    while day.moments.len() < request.actions && refusals < MOST_REFUSALS {
        let last = &day.states[day.states.len() - 1];
        let Some(node) = last.draw_next_after(refusals) else { break };
        match next(&mut walker, last, node, refusals, cx)? {
            Ok((state, moment)) => {
                refusals = 0;
                day.moments.push(moment);
                day.states.push(state);
                day.clip = walker.clip();
                cx.preview(day.clone());
                cx.step(day.moments.len(), request.actions)?;
            }
            Err(why) => {
                refusals += 1;
                day.refused.push(why);
            }
        }
    }
    if day.moments.is_empty() {
        let why = day.refused.first().map_or("the room has no key object", String::as_str);
        return Err(Stop::Failed(format!("nothing can be done here: {why}")));
    }
    Ok(day)
}

/// The same room without what only groups do.
fn alone(start: &Evolution) -> Evolution {
    let config: &EvolutionConfig = start.config();
    let of_one = |kind: &ActionKind| *kind != ActionKind::EatDinnerInGroup;
    let wanted = if config.only.is_empty() { ActionKind::ALL.to_vec() } else { config.only.clone() };
    let only = wanted.into_iter().filter(of_one).collect();
    start.with_config(EvolutionConfig { only, ..config.clone() })
}

/// Does an action and walks there; says why not where that fails, and nothing is changed then.
fn next(
    walker: &mut Walker<'_>,
    last: &Evolution,
    node: usize,
    roll: u64,
    cx: &JobCtx<Day>,
) -> Result<Result<(Evolution, Moment), String>, Stop> {
    let state = match last.apply(node, roll) {
        Ok(state) => state,
        Err(refused) => return Ok(Err(refused.to_string())),
    };
    let Some(step) = state.steps().last().cloned() else { return Ok(Err("nothing was done".to_owned())) };
    let people = embody_as(&state, Some(walker.betas()), 0, &cx.ticker().without_progress())?;
    let (Some(fitted), Some(planned)) = (people.first(), step.people.first()) else {
        return Ok(Err(format!("\"{}\": nobody is there", step.action)));
    };
    let there = At::of(&fitted.person, planned);
    let quiet: JobCtx<JourneyPreview> =
        JobCtx::watched(cx.seed.child("walk", step.number as u64), cx.ticker().without_progress());
    let times = match walker.go(&state, &there, &quiet)? {
        Ok(times) => times,
        Err(why) => return Ok(Err(format!("\"{}\" at {}: {why}", step.action, step.key_name))),
    };
    let moment = Moment {
        step: step.number,
        action: step.action.clone(),
        key: step.key_name.clone(),
        changes_s: times.changes_s,
        arrives_s: times.arrives_s,
        leaves_s: times.leaves_s,
        walked: times.walked,
    };
    Ok(Ok((state, moment)))
}
