//! What learning tells about itself: counts after each filter, nodes, thin ones, layouts beside reference fits,
//! likelihood of held-out photos.

use std::collections::BTreeMap;

use serde::Serialize;

use super::instances::{Found, Funnel, InstanceConfig};
use super::layout::{LayoutFrame, PhotoFrame, PolarUnits};
use super::likelihood::Likelihood;
use super::nodes::{self, ModelConfig, fit_density};
use super::posture::{self, PostureEvidence};
use crate::evolve::action::{ActionGraph, ActionKind, ActionModel, Evidence, Posture};
use crate::job::Seed;

/// With fewer instances a node says little of its own.
pub const THIN: usize = 15;

/// The whole report. Field names are a contract with people's scripts: add, never rename.
#[derive(Clone, Debug, Serialize)]
pub struct ActionReport {
    /// Always `learn actions`.
    pub command: String,
    /// Version of the program.
    pub version: String,
    /// Root of the seed tree.
    pub seed: u64,
    /// Settings of the filters.
    pub instances: InstanceConfig,
    /// Settings of the model.
    pub model: ModelConfig,
    /// Photos with captions.
    pub photos_with_captions: usize,
    /// Photos with interactions.
    pub photos_with_interactions: usize,
    /// Photos with at least one instance.
    pub photos_used: usize,
    /// People whose joints were left out for want of the photo's size.
    pub people_without_size: usize,
    /// Photos left after each filter, by type.
    pub funnels: BTreeMap<String, Funnel>,
    /// Every node.
    pub nodes: Vec<NodeRow>,
    /// What rests on little.
    pub warnings: Vec<String>,
    /// How postures are known.
    pub posture_evidence: BTreeMap<String, usize>,
    /// Of people marked as sitting with at least two leg angles seen, the share that eq. 1 calls seated.
    pub seated_told_by_angles: Option<f32>,
    /// How many that are.
    pub seated_asked: usize,
    /// Fits beside the reference.
    pub reference: Vec<ReferenceRow>,
    /// Held-out photos.
    pub likelihood: Likelihood,
    /// Probability of each node after each.
    pub graph: ActionGraph,
    /// Seconds of each stage.
    pub seconds: BTreeMap<String, f64>,
}

/// A node in the report.
#[derive(Clone, Debug, Serialize)]
pub struct NodeRow {
    /// Its name.
    pub node: String,
    /// Instances.
    pub instances: usize,
    /// Of these, where everything is marked.
    pub complete: usize,
    /// Where the key object is seen: mean in degrees and κ.
    pub key_angle: Option<[f64; 2]>,
    /// Objects with their frequency and places.
    pub objects: Vec<ObjectRow>,
    /// Relations between objects.
    pub pairs: usize,
}

/// An object in the report.
#[derive(Clone, Debug, Serialize)]
pub struct ObjectRow {
    /// Category.
    pub object: String,
    /// C(o).
    pub frequency: f64,
    /// Median distance, metres.
    pub distance_m: f64,
    /// Standard deviation of ln distance.
    pub sigma: f64,
    /// Direction: weight, degrees, κ of each component.
    pub direction: Vec<[f64; 3]>,
    /// Places it rests on.
    pub places: usize,
    /// Whose places these are.
    pub evidence: Evidence,
}

/// A layout of something in use, fitted as the reference was: units of the photo, origin in the torso.
#[derive(Clone, Debug, Serialize)]
pub struct ReferenceRow {
    /// Object and action.
    pub pair: String,
    /// Places; the reference's.
    pub places: [usize; 2],
    /// μ of ln distance; the reference's.
    pub mu: [f64; 2],
    /// σ; the reference's.
    pub sigma: [f64; 2],
    /// Mean direction of the whole mixture, degrees; the reference's.
    pub direction_deg: [f64; 2],
    /// Mean resultant length of the whole mixture, 0 (every direction) to 1 (one); the reference's.
    pub concentration: [f64; 2],
}

/// A fit of an independent prototype to V-COCO, pitch 20°, unlowered origin.
struct Reference {
    object: &'static str,
    kinds: &'static [ActionKind],
    places: usize,
    mu: f64,
    sigma: f64,
    /// Weight, degrees, κ.
    direction: &'static [[f64; 3]],
}

const EATING: &[ActionKind] = &[ActionKind::EatDinner, ActionKind::EatSnacks];
const REFERENCES: [Reference; 6] = [
    Reference {
        object: "laptop",
        kinds: &[ActionKind::UseLaptop],
        places: 221,
        mu: 0.11,
        sigma: 0.66,
        direction: &[[0.16, 86.0, 35.7], [0.84, 89.0, 1.7]],
    },
    Reference {
        object: "book",
        kinds: &[ActionKind::ReadBook],
        places: 124,
        mu: -0.02,
        sigma: 0.68,
        direction: &[[0.43, 90.0, 9.1], [0.57, 45.0, 0.3]],
    },
    Reference {
        object: "knife",
        kinds: &[ActionKind::PrepareFood],
        places: 176,
        mu: 0.56,
        sigma: 0.53,
        direction: &[[1.0, 83.0, 3.0]],
    },
    Reference {
        object: "fork",
        kinds: EATING,
        places: 56,
        mu: -0.19,
        sigma: 0.55,
        direction: &[[0.64, 88.0, 5.7], [0.36, -72.0, 1.3]],
    },
    Reference {
        object: "pizza",
        kinds: EATING,
        places: 59,
        mu: 0.12,
        sigma: 0.46,
        direction: &[[0.63, 86.0, 24.2], [0.37, -63.0, 1.0]],
    },
    Reference {
        object: "tv",
        kinds: &[ActionKind::WatchTv],
        places: 38,
        mu: 1.15,
        sigma: 0.51,
        direction: &[[0.25, 104.0, 109.0], [0.44, 57.0, 16.0], [0.31, 154.0, 1.3]],
    },
];

/// Layouts of things in use beside the reference fits.
pub fn reference_rows(found: &Found, config: &ModelConfig, seed: Seed) -> Vec<ReferenceRow> {
    let frame = LayoutFrame::Pitched { pitch_deg: 20.0, lowered: false };
    let rows = REFERENCES.iter().filter_map(|reference| {
        let mut places: Vec<PolarUnits> = Vec::new();
        for instance in found.instances.iter().filter(|i| reference.kinds.contains(&i.kind)) {
            let Some(plan) = PhotoFrame::of(&instance.pose, instance.posture, frame) else { continue };
            let used = instance.things.iter().filter(|t| t.used && t.object == reference.object);
            places.extend(used.map(|t| plan.polar(t.pixel)));
        }
        let density = fit_density(&places, Evidence::Everything, config, 1.0, seed)?;
        let direction = crate::math::directions::VonMisesMixture {
            components: reference
                .direction
                .iter()
                .map(|[w, mean, kappa]| {
                    (*w, crate::math::directions::VonMises { mean_rad: mean.to_radians(), kappa: *kappa })
                })
                .collect(),
        };
        let (own, theirs) = (density.direction.resultant(), direction.resultant());
        Some(ReferenceRow {
            pair: format!("{} / {}", reference.object, reference.kinds[0].label()),
            places: [places.len(), reference.places],
            mu: [density.distance_m.mu, reference.mu],
            sigma: [density.distance_m.sigma, reference.sigma],
            direction_deg: [own.mean_rad.to_degrees(), theirs.mean_rad.to_degrees()],
            concentration: [own.length, theirs.length],
        })
    });
    rows.collect()
}

/// A row for every node.
pub fn node_rows(model: &ActionModel) -> Vec<NodeRow> {
    let objects = |node: &crate::evolve::action::ActionNode| {
        node.around_person
            .iter()
            .map(|p| ObjectRow {
                object: p.object.clone(),
                frequency: node.frequency(&p.object),
                distance_m: p.density.distance_m.median(),
                sigma: p.density.distance_m.sigma,
                direction: p
                    .density
                    .direction
                    .components
                    .iter()
                    .map(|(w, c)| [*w, c.mean_rad.to_degrees(), c.kappa])
                    .collect(),
                places: p.density.samples,
                evidence: p.density.evidence,
            })
            .collect()
    };
    model
        .nodes
        .iter()
        .map(|node| NodeRow {
            node: node.label(),
            instances: node.instances,
            complete: node.complete_instances,
            key_angle: node.key_angle.map(|a| [a.mean_rad.to_degrees(), a.kappa]),
            objects: objects(node),
            pairs: node.between.len(),
        })
        .collect()
}

/// What rests on little, in words for the user.
pub fn warnings(model: &ActionModel) -> Vec<String> {
    let mut warnings = Vec::new();
    for kind in ActionKind::ALL {
        if !model.nodes.iter().any(|n| n.kind == kind) {
            warnings.push(format!("no photo shows \"{}\": add annotations of it", kind.label()));
        }
    }
    for node in &model.nodes {
        if node.instances < THIN {
            warnings.push(format!("\"{}\" rests on {} instances", node.label(), node.instances));
        }
        if node.complete_instances < THIN {
            warnings.push(format!(
                "\"{}\": {} instances show all their objects; how many there are leans on all photos of its type",
                node.label(),
                node.complete_instances
            ));
        }
    }
    warnings
}

/// How often what says how people are.
pub fn posture_evidence(found: &Found) -> BTreeMap<String, usize> {
    let mut counts = BTreeMap::new();
    for instance in &found.instances {
        *counts.entry(format!("{:?}", instance.posture_evidence).to_lowercase()).or_default() += 1;
    }
    counts
}

/// Of people marked as sitting, how many have two leg angles seen and what share of these eq. 1 calls seated.
pub fn seated_told_by_angles(found: &Found) -> (usize, Option<f32>) {
    let among = [Posture::Stand, Posture::Sit, Posture::SitStraight];
    let marked = found.instances.iter().filter(|i| {
        i.posture_evidence == PostureEvidence::Verb
            && matches!(i.posture, Posture::Sit | Posture::SitStraight)
    });
    let angles = marked.map(|i| posture::leg_angles(&i.pose)).filter(|a| a.iter().flatten().count() >= 2);
    let told: Vec<bool> =
        angles.filter_map(|a| posture::nearest(&a, &among)).map(|p| p != Posture::Stand).collect();
    let share = told.iter().filter(|t| **t).count() as f32 / told.len().max(1) as f32;
    (told.len(), (!told.is_empty()).then_some(share))
}

/// Places of an object around people of one node, units, for scatter beside its density.
pub fn places_of(found: &Found, key: nodes::NodeKey, object: &str) -> Vec<PolarUnits> {
    let own = found.instances.iter().filter(|i| nodes::node_key(i) == key);
    own.flat_map(nodes::placed).filter(|t| t.object == object).map(|t| t.from_person).collect()
}
