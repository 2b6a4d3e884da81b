//! Which things an action needs (occurrence model C) and how well a place suits one (eq. 10).

use std::f64::consts::TAU;

use rand::RngExt as _;

use super::library::{KindId, Library};
use super::step::Failed;
use crate::evolve::action::{ActionNode, Evidence, PersonFrame, Polar, PolarDensity};
use crate::job::Rng;
use crate::math::LogNormal;
use crate::math::directions::{PreparedMixture, VonMises, VonMisesMixture};
use glam::Vec3;

/// ADSE §5.2: things that are there more often than this make the working zone.
pub const ZONE_FREQUENCY: f64 = 0.5;
/// Where something lies of which nothing was learned: within reach, in front.
const UNKNOWN_M: f64 = 0.55;

/// One thing that the action needs.
#[derive(Clone, Debug, PartialEq)]
pub struct Want {
    /// Its kind.
    pub kind: KindId,
    /// How the model calls it.
    pub label: String,
    /// C(o).
    pub frequency: f64,
    /// All of the group wants it.
    pub shared: bool,
}

/// Draws what the action needs, most frequent first, larger first among equals. What the library has no model for is
/// told in `failed` unless it is a fixture.
pub fn draw(
    node: &ActionNode,
    library: &Library,
    companions: bool,
    rng: &mut Rng,
    failed: &mut Vec<Failed>,
) -> Vec<Want> {
    let mut wants = Vec::new();
    for occurrence in &node.occurrence {
        let count = occurrence.draw(rng);
        let frequency = occurrence.frequency();
        match library.of_label(&occurrence.object) {
            Some(kind) => {
                let count = count.min(library.kind(kind).at_once.max(1));
                wants.extend((0..count).map(|_| Want {
                    kind,
                    label: occurrence.object.clone(),
                    frequency,
                    shared: false,
                }))
            }
            None if count > 0 && !library.is_fixture(&occurrence.object) => failed.push(Failed {
                object: occurrence.object.clone(),
                why: "the library has no such kind: add one with a model".to_owned(),
            }),
            None => {}
        }
    }
    if companions {
        for companion in library.companions(node.kind.label()) {
            let Some(kind) = library.named(&companion.object) else { continue };
            let mut left: f64 = rng.random();
            let count = companion.probability.iter().position(|p| {
                left -= p;
                left < 0.0
            });
            let frequency = 1.0 - companion.probability.first().copied().unwrap_or(0.0);
            let want = Want { kind, label: companion.object.clone(), frequency, shared: false };
            wants.extend((0..count.unwrap_or(0)).map(|_| want.clone()));
        }
    }
    let size = |want: &Want| library.thing(want.kind, 0).map_or(0.0, |t| t.shape.volume_m3());
    // Sorting by steps of a tenth keeps "about as frequent" together, where size decides.
    let rank = |want: &Want| (want.frequency * 10.0).round();
    wants.sort_by(|a, b| {
        rank(b).total_cmp(&rank(a)).then(size(b).total_cmp(&size(a))).then(a.label.cmp(&b.label))
    });
    wants
}

/// Where one person's things lie: P(o) of eq. 10.
pub struct Layout<'a> {
    node: &'a ActionNode,
    library: &'a Library,
    frame: PersonFrame,
    placed: Vec<(String, Vec3)>,
}

impl<'a> Layout<'a> {
    /// Nothing placed yet.
    pub fn new(node: &'a ActionNode, library: &'a Library, frame: PersonFrame) -> Self {
        Self { node, library, frame, placed: Vec::new() }
    }

    /// A thing is there now; others are placed with respect to it.
    pub fn add(&mut self, label: &str, at: Vec3) {
        self.placed.push((label.to_owned(), at));
    }

    /// How a thing's place is valued.
    pub fn of(&self, label: &str) -> Preference {
        let person = self.node.placement(label).map(|p| p.density.clone());
        let person = person.unwrap_or_else(|| self.by_hand(label));
        let pairs = self.node.pairs_of(label).flat_map(|pair| {
            let there = self.placed.iter().filter(|(other, _)| *other == pair.reference);
            there.map(|(_, at)| (pair.together, self.frame.at(*at), Prepared::of(&pair.density)))
        });
        Preference { frame: self.frame, person: Prepared::of(&person), pairs: pairs.collect() }
    }

    fn by_hand(&self, label: &str) -> PolarDensity {
        let written = self.library.companions(self.node.kind.label()).find(|c| c.object == label);
        let (distance_m, spread, angle_deg, kappa) =
            written.map_or((UNKNOWN_M, 0.3, 90.0, 2.0), |c| (c.distance_m, c.spread, c.angle_deg, c.kappa));
        let direction = VonMises { mean_rad: angle_deg * TAU / 360.0, kappa };
        PolarDensity {
            distance_m: LogNormal { mu: distance_m.ln(), sigma: spread },
            direction: VonMisesMixture { components: vec![(1.0, direction)] },
            samples: 0,
            evidence: Evidence::Everything,
        }
    }
}

/// P(o) of eq. 10 for one thing.
pub struct Preference {
    frame: PersonFrame,
    person: Prepared,
    pairs: Vec<(f64, PersonFrame, Prepared)>,
}

/// A [`PolarDensity`] that is asked about thousands of places.
struct Prepared {
    distance_m: LogNormal,
    direction: PreparedMixture,
}

impl Prepared {
    fn of(density: &PolarDensity) -> Self {
        Self { distance_m: density.distance_m, direction: PreparedMixture::of(&density.direction) }
    }

    /// As [`PolarDensity::density`].
    fn density(&self, polar: Polar) -> f64 {
        let distance = self.distance_m.ln_density(f64::from(polar.distance_m));
        (distance + self.direction.ln_density(f64::from(polar.angle_rad))).exp()
    }
}

impl Preference {
    /// P(o, H) + Σ f(o, o') P(o, o') at a place.
    pub fn at(&self, point: Vec3) -> f32 {
        let pairs = self
            .pairs
            .iter()
            .map(|(together, frame, density)| together * density.density(frame.polar_of(point)));
        (self.person.density(self.frame.polar_of(point)) + pairs.sum::<f64>()) as f32
    }
}
