use serde::{Deserialize, Serialize};

use super::frame::Polar;
use super::graph::ActionGraph;
use super::group::GroupModel;
use crate::math::LogNormal;
use crate::math::directions::{VonMises, VonMisesMixture};
use crate::scene::{Category, PoseFamily};

/// The eight types of action (ADSE §4.1).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum ActionKind {
    /// At a desktop computer: monitor, keyboard, mouse.
    UseComputer,
    /// With a laptop.
    UseLaptop,
    /// Read a book.
    ReadBook,
    /// Cut, cook, bake.
    PrepareFood,
    /// Watch television.
    WatchTv,
    /// A bite without a set table.
    EatSnacks,
    /// A meal.
    EatDinner,
    /// A meal of two to four people around one table.
    EatDinnerInGroup,
}

impl ActionKind {
    /// All eight, in the paper's order.
    pub const ALL: [Self; 8] = [
        Self::UseComputer,
        Self::UseLaptop,
        Self::ReadBook,
        Self::PrepareFood,
        Self::WatchTv,
        Self::EatSnacks,
        Self::EatDinner,
        Self::EatDinnerInGroup,
    ];

    /// Name for people, reports and the command line.
    pub fn label(self) -> &'static str {
        match self {
            Self::UseComputer => "use computer",
            Self::UseLaptop => "use laptop",
            Self::ReadBook => "read book",
            Self::PrepareFood => "prepare food",
            Self::WatchTv => "watch tv",
            Self::EatSnacks => "eat snacks",
            Self::EatDinner => "eat dinner",
            Self::EatDinnerInGroup => "eat dinner in group",
        }
    }

    /// The type that a label (of [`ActionKind::label`]) names.
    pub fn from_label(label: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.label() == label)
    }
}

/// The five representative poses (ADSE fig. 6), by what hips and knees do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum Posture {
    /// On the feet.
    Stand,
    /// Hips and knees bent.
    Sit,
    /// Hips bent, knees straight.
    SitStraight,
    /// On the belly.
    LieDown,
    /// On the back.
    LieUp,
}

impl Posture {
    /// All five, in the paper's order.
    pub const ALL: [Self; 5] = [Self::Stand, Self::Sit, Self::SitStraight, Self::LieDown, Self::LieUp];

    /// As in "use laptop on desk while *sitting*".
    pub fn label(self) -> &'static str {
        match self {
            Self::Stand => "standing",
            Self::Sit => "sitting",
            Self::SitStraight => "sitting with straight legs",
            Self::LieDown => "lying face down",
            Self::LieUp => "lying face up",
        }
    }
}

/// Where an action happens (ADSE §4.1): what is fixed in the room, places the person and carries most objects.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum KeyObject {
    /// A desk.
    OfficeDesk,
    /// A dining table.
    DiningTable,
    /// A coffee table.
    CoffeeTable,
    /// A kitchen island or counter.
    KitchenIsland,
    /// A bed.
    Bed,
    /// A couch or armchair.
    Couch,
}

impl KeyObject {
    /// All six, in the paper's order.
    pub const ALL: [Self; 6] =
        [Self::OfficeDesk, Self::DiningTable, Self::CoffeeTable, Self::KitchenIsland, Self::Bed, Self::Couch];

    /// Name for people and reports.
    pub fn label(self) -> &'static str {
        match self {
            Self::OfficeDesk => "desk",
            Self::DiningTable => "dining table",
            Self::CoffeeTable => "coffee table",
            Self::KitchenIsland => "kitchen island",
            Self::Bed => "bed",
            Self::Couch => "couch",
        }
    }

    /// Categories of a room's objects that serve as it, best first; a plain table serves as the tables that the
    /// photos don't tell apart.
    pub fn categories(self) -> &'static [Category] {
        match self {
            Self::OfficeDesk => &[Category::OfficeDesk, Category::Table],
            Self::DiningTable => &[Category::DiningTable, Category::Table],
            Self::CoffeeTable => &[Category::CoffeeTable],
            Self::KitchenIsland => &[Category::KitchenIsland, Category::Counter],
            Self::Bed => &[Category::Bed],
            Self::Couch => &[Category::Sofa],
        }
    }
}

/// Where the person is with respect to the key object (ADSE §4.1).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum KeyRelation {
    /// On top of it.
    On,
    /// Beside it.
    Around,
}

/// How often how many of an object are there while an action goes on: C(o, n), ADSE §4.2.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Occurrence {
    /// COCO's name of the object's category ("laptop", "cup", "wine glass"), but a computer's screen, which COCO calls
    /// "tv", is "monitor". Key objects and seats (chair, bench, couch, bed) are never listed.
    pub object: String,
    /// Probability of n pieces at position n; sums to one.
    pub probability: Vec<f64>,
}

impl Occurrence {
    /// C(o): probability of at least one.
    pub fn frequency(&self) -> f64 {
        self.probability.iter().skip(1).sum()
    }

    /// Draws how many.
    pub fn draw(&self, rng: &mut impl rand::Rng) -> usize {
        use rand::RngExt as _;
        let mut left: f64 = rng.random();
        for (count, probability) in self.probability.iter().enumerate() {
            left -= probability;
            if left < 0.0 {
                return count;
            }
        }
        0
    }
}

/// Whose samples a distribution was fitted to: the node's own or, where these are too few, more.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Evidence {
    /// The node's own.
    Node,
    /// All nodes of the same type of action.
    Action,
    /// All actions.
    Everything,
}

/// Where something lies: a lognormal distance times a mixture of von Mises directions (ADSE eq. 2), metres and
/// radians in the polar frame of [`super::PersonFrame`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PolarDensity {
    /// Distance on the floor plan, metres.
    pub distance_m: LogNormal,
    /// Direction.
    pub direction: VonMisesMixture,
    /// Places that it was fitted to.
    pub samples: usize,
    /// Whose places these were.
    pub evidence: Evidence,
}

impl PolarDensity {
    /// P(r, φ) of eq. 2, natural logarithm, per metre and radian: the factor of eq. 9 and 10.
    pub fn ln_density(&self, polar: Polar) -> f64 {
        self.distance_m.ln_density(f64::from(polar.distance_m))
            + self.direction.ln_density(f64::from(polar.angle_rad))
    }

    /// P(r, φ) of eq. 2.
    pub fn density(&self, polar: Polar) -> f64 {
        self.ln_density(polar).exp()
    }

    /// The same per square metre of the floor plan: P(r, φ) / r. For comparing places drawn uniformly over an area.
    pub fn density_per_m2(&self, polar: Polar) -> f64 {
        self.density(polar) / f64::from(polar.distance_m).max(1e-6)
    }

    /// Draws a place.
    pub fn sample(&self, rng: &mut impl rand::Rng) -> Polar {
        Polar { distance_m: self.distance_m.sample(rng) as f32, angle_rad: self.direction.sample(rng) as f32 }
    }
}

/// Where an object is with respect to the person, P(o, H).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Placement {
    /// Category, as in [`Occurrence::object`].
    pub object: String,
    /// From the person's centre.
    pub density: PolarDensity,
}

/// Where an object is with respect to another, P(o, o'); only pairs that are together in at least half of the
/// instances (ADSE §4.2).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PairPlacement {
    /// The object o, category as in [`Occurrence::object`].
    pub object: String,
    /// The object o' that it is seen from: the person's axes with the origin there.
    pub reference: String,
    /// f(o, o'): share of the instances with both.
    pub together: f64,
    /// From the reference's centre.
    pub density: PolarDensity,
}

/// One action: what (type), where (key object) and how (posture), with which objects, and how these lie.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ActionNode {
    /// What.
    pub kind: ActionKind,
    /// Where.
    pub key: KeyObject,
    /// On it or beside it.
    pub relation: KeyRelation,
    /// How.
    pub posture: Posture,
    /// Instances (one person doing it in one photo) in the node.
    pub instances: usize,
    /// Instances in photos whose objects are all annotated: what occurrence and pairs rest on.
    pub complete_instances: usize,
    /// Angle at which the person sees the key object's centre, P(H, K); `None` on it, where the key object's own
    /// front decides.
    pub key_angle: Option<VonMises>,
    /// C(o, n) of every object that occurs often enough, most frequent first.
    pub occurrence: Vec<Occurrence>,
    /// P(o, H) of every object of `occurrence`.
    pub around_person: Vec<Placement>,
    /// P(o, o') of the pairs.
    pub between: Vec<PairPlacement>,
    /// What a group shares; `None` for what people do alone. Everything else then describes each of them.
    pub group: Option<GroupModel>,
}

impl ActionNode {
    /// "use laptop on desk while sitting".
    pub fn label(&self) -> String {
        let place = match (self.relation, self.key) {
            (KeyRelation::Around, KeyObject::Bed | KeyObject::Couch) => "at",
            _ => "on",
        };
        format!("{} {place} {} while {}", self.kind.label(), self.key.label(), self.posture.label())
    }

    /// The family whose sampled bodies show the posture at this key object.
    pub fn pose_family(&self) -> PoseFamily {
        match (self.posture, self.relation, self.key) {
            (Posture::Stand, ..) => PoseFamily::Stand,
            (Posture::Sit, KeyRelation::On, KeyObject::Couch) | (Posture::Sit, _, KeyObject::CoffeeTable) => {
                PoseFamily::SitSofa
            }
            (Posture::Sit, KeyRelation::On, KeyObject::Bed) => PoseFamily::SitEdge,
            (Posture::Sit, _, KeyObject::KitchenIsland) => PoseFamily::SitStool,
            (Posture::Sit, ..) => PoseFamily::SitChair,
            (Posture::SitStraight, ..) => PoseFamily::SitStraight,
            (Posture::LieDown, ..) => PoseFamily::LieDown,
            (Posture::LieUp, ..) => PoseFamily::LieUp,
        }
    }

    /// C(o, n) of an object, `None` where it is never involved.
    pub fn occurrence_of(&self, object: &str) -> Option<&Occurrence> {
        self.occurrence.iter().find(|o| o.object == object)
    }

    /// C(o): probability of at least one.
    pub fn frequency(&self, object: &str) -> f64 {
        self.occurrence_of(object).map_or(0.0, Occurrence::frequency)
    }

    /// P(o, H) of an object.
    pub fn placement(&self, object: &str) -> Option<&Placement> {
        self.around_person.iter().find(|p| p.object == object)
    }

    /// P(o, o') of every reference that an object is placed by.
    pub fn pairs_of(&self, object: &str) -> impl Iterator<Item = &PairPlacement> {
        self.between.iter().filter(move |p| p.object == object)
    }
}

/// Where a model comes from.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Provenance {
    /// The command that made it.
    pub command: String,
    /// Licence and credit of the annotations.
    pub licence: String,
    /// Photos with at least one instance.
    pub images: usize,
}

/// What people do indoors: all action nodes. Its [`ActionGraph`] follows from them.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ActionModel {
    /// Where it comes from.
    pub provenance: Provenance,
    /// Metres that one unit of the photos' frame (a projected torso length) was taken for; distances here are in
    /// metres already.
    pub metres_per_unit: f64,
    /// The nodes, by type, key object and posture.
    pub nodes: Vec<ActionNode>,
}

/// Why an action model can't be used.
#[derive(Debug, thiserror::Error)]
pub enum ActionModelError {
    /// Not the text it should be.
    #[error("action model: {0}; make the file again with `inhabit learn actions`")]
    Syntax(#[from] ron::error::SpannedError),
    /// A number that no distribution has.
    #[error(
        "action model, node \"{node}\", {place}: {what}; make the file again with `inhabit learn actions`"
    )]
    Number {
        /// The node's label.
        node: String,
        /// The object or relation.
        place: String,
        /// What is wrong.
        what: &'static str,
    },
}

impl ActionModel {
    /// Reads and checks the RON text of a model.
    ///
    /// # Errors
    /// [`ActionModelError`].
    pub fn from_ron(text: &str) -> Result<Self, ActionModelError> {
        let model: Self = ron::from_str(text)?;
        model.nodes.iter().try_for_each(ActionNode::check)?;
        Ok(model)
    }

    /// The RON text of a model.
    ///
    /// # Errors
    /// What the serialiser says; it never fails on numbers.
    pub fn to_ron(&self) -> Result<String, ron::Error> {
        ron::ser::to_string_pretty(self, ron::ser::PrettyConfig::new().depth_limit(5))
    }

    /// Which action follows which.
    pub fn graph(&self) -> ActionGraph {
        ActionGraph::of(&self.nodes)
    }
}

impl ActionNode {
    fn check(&self) -> Result<(), ActionModelError> {
        for occurrence in self.occurrence.iter().chain(self.group.iter().flat_map(|g| &g.shared)) {
            let sum: f64 = occurrence.probability.iter().sum();
            let sound = occurrence.probability.iter().all(|p| *p >= 0.0) && (sum - 1.0).abs() < 1e-3;
            self.demand(sound, &occurrence.object, "the probabilities do not sum to one")?;
        }
        for placement in &self.around_person {
            self.check_density(&placement.object, &placement.density)?;
        }
        for pair in &self.between {
            self.check_density(&format!("{} seen from {}", pair.object, pair.reference), &pair.density)?;
        }
        self.demand(self.key_angle.is_none_or(is_direction), "key object", "its direction is not finite")
    }

    fn check_density(&self, place: &str, density: &PolarDensity) -> Result<(), ActionModelError> {
        let LogNormal { mu, sigma } = density.distance_m;
        self.demand(mu.is_finite() && sigma.is_finite() && sigma > 0.0, place, "its distance has no spread")?;
        let parts = &density.direction.components;
        let weights: f64 = parts.iter().map(|(weight, _)| *weight).sum();
        let sound = parts.iter().all(|(weight, part)| *weight > 0.0 && is_direction(*part));
        self.demand(sound && (weights - 1.0).abs() < 1e-3, place, "its directions' weights do not sum to one")
    }

    fn demand(&self, sound: bool, place: &str, what: &'static str) -> Result<(), ActionModelError> {
        if sound {
            return Ok(());
        }
        Err(ActionModelError::Number { node: self.label(), place: place.to_owned(), what })
    }
}

fn is_direction(part: VonMises) -> bool {
    part.mean_rad.is_finite() && part.kappa.is_finite() && part.kappa >= 0.0
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A node with these objects at these frequencies, each right in front.
    pub(in super::super) fn node(kind: ActionKind, key: KeyObject, objects: &[(&str, f64)]) -> ActionNode {
        let density = PolarDensity {
            distance_m: LogNormal { mu: -0.5, sigma: 0.3 },
            direction: VonMisesMixture { components: vec![(1.0, VonMises { mean_rad: 1.57, kappa: 8.0 })] },
            samples: 10,
            evidence: Evidence::Node,
        };
        ActionNode {
            kind,
            key,
            relation: KeyRelation::Around,
            posture: Posture::Sit,
            instances: 10,
            complete_instances: 5,
            key_angle: Some(VonMises { mean_rad: 1.57, kappa: 4.0 }),
            occurrence: objects
                .iter()
                .map(|(object, often)| Occurrence {
                    object: (*object).to_owned(),
                    probability: vec![1.0 - often, *often],
                })
                .collect(),
            around_person: objects
                .iter()
                .map(|(object, _)| Placement { object: (*object).to_owned(), density: density.clone() })
                .collect(),
            between: Vec::new(),
            group: None,
        }
    }

    fn model() -> ActionModel {
        let nodes = vec![node(ActionKind::UseLaptop, KeyObject::OfficeDesk, &[("laptop", 0.9)])];
        ActionModel { metres_per_unit: 0.5, nodes, ..ActionModel::default() }
    }

    #[test]
    fn a_model_survives_a_round_trip_through_its_file() {
        let text = model().to_ron().expect("text");
        assert_eq!(ActionModel::from_ron(&text).expect("sound"), model());
        assert_eq!(model().nodes[0].label(), "use laptop on desk while sitting");
    }

    #[test]
    fn a_file_with_impossible_numbers_is_refused_with_node_and_place() {
        let refused = |change: &dyn Fn(&mut ActionNode)| {
            let mut model = model();
            change(&mut model.nodes[0]);
            let text = model.to_ron().expect("text");
            ActionModel::from_ron(&text).expect_err("must refuse").to_string()
        };
        let says = refused(&|n| n.occurrence[0].probability = vec![0.5, 0.9]);
        assert!(says.contains("use laptop on desk while sitting") && says.contains("laptop"), "{says}");
        assert!(refused(&|n| n.around_person[0].density.distance_m.sigma = 0.0).contains("spread"));
        assert!(refused(&|n| n.around_person[0].density.direction.components.clear()).contains("weights"));
        assert!(matches!(ActionModel::from_ron("(nodes:"), Err(ActionModelError::Syntax(_))));
    }

    #[test]
    fn drawn_counts_follow_the_occurrence() {
        use rand::SeedableRng as _;
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(2);
        let cups = Occurrence { object: "cup".to_owned(), probability: vec![0.5, 0.3, 0.2] };
        let mean = (0..20_000).map(|_| cups.draw(&mut rng) as f64).sum::<f64>() / 20_000.0;
        assert!((mean - 0.7).abs() < 0.02, "{mean}");
    }
}
