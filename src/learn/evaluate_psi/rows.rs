use serde::{Deserialize, Serialize};

use crate::inspect::{BodyMetrics, Diversity};

/// What was done to the bodies before they were measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Stage {
    /// As they were placed.
    Before,
    /// After the published fit (eq. 8 with the published settings).
    PublishedFit,
    /// After our fit.
    OurFit,
}

impl Stage {
    /// All, in the order of the tables.
    pub const ALL: [Self; 3] = [Self::Before, Self::PublishedFit, Self::OurFit];

    /// What stands behind a method's name in the tables.
    pub fn suffix(self) -> &'static str {
        match self {
            Self::Before => "",
            Self::PublishedFit => " + L_f",
            Self::OurFit => " + our fit",
        }
    }

    /// Name in legends.
    pub fn label(self) -> &'static str {
        match self {
            Self::Before => "before fitting",
            Self::PublishedFit => "after the paper's fitting",
            Self::OurFit => "after our fitting",
        }
    }
}

/// One row of Tables 2 and 3: a method at a stage, over one room or a set of rooms.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PhysicalRow {
    /// Bodies measured.
    pub bodies: usize,
    /// PSI §4.1.4: mean share of vertices in free space.
    pub psi_non_collision: f32,
    /// PSI §4.1.4: share of bodies with a vertex at or in a surface.
    pub psi_contact: f32,
    /// Share of bodies with a contact vertex within 2 cm of a surface, from either side.
    pub contact_2cm: f32,
    /// Mean over bodies of the deepest penetration in millimetres.
    pub penetration_max_mm: f32,
    /// Share of bodies whose weight stands over what carries it.
    pub supported: f32,
    /// Share of bodies wholly inside the room.
    pub inside: f32,
    /// Share of bodies without any finding: they could be there.
    pub faultless: f32,
    /// Mean contact area in square centimetres.
    pub contact_area_cm2: f32,
    /// Bodies that were clustered, in camera frames; 0 if they were too few, and nothing in what follows.
    pub diverse_bodies: usize,
    /// Entropy over 20 clusters of the parameters in camera frames, in nats (at most 2.996).
    pub entropy_camera_nats: Option<f32>,
    /// Mean distance to the cluster's centre, camera frames.
    pub cluster_size_camera: Option<f32>,
    /// Entropy in the world frame, in nats.
    pub entropy_world_nats: Option<f32>,
    /// Mean distance to the cluster's centre, world frame.
    pub cluster_size_world: Option<f32>,
}

impl PhysicalRow {
    /// Of measured bodies, each with whether it is without findings, and their diversity in camera frames and
    /// in the world frame, where they are enough for one.
    pub fn of(measured: &[(BodyMetrics, bool)], camera: Option<Diversity>, world: Option<Diversity>) -> Self {
        let mean = |value: &dyn Fn(&(BodyMetrics, bool)) -> f32| {
            measured.iter().map(value).sum::<f32>() / measured.len().max(1) as f32
        };
        let share = |holds: &dyn Fn(&(BodyMetrics, bool)) -> bool| mean(&|m| f32::from(u8::from(holds(m))));
        Self {
            bodies: measured.len(),
            psi_non_collision: mean(&|m| m.0.psi_non_collision),
            psi_contact: share(&|m| m.0.psi_contact),
            contact_2cm: share(&|m| m.0.contact_2cm),
            penetration_max_mm: mean(&|m| m.0.penetration_max_mm),
            supported: share(&|m| m.0.supported),
            inside: share(&|m| m.0.outside_field == 0),
            faultless: share(&|m| m.1),
            contact_area_cm2: mean(&|m| m.0.contact_area_cm2),
            diverse_bodies: camera.map_or(0, |d| d.bodies),
            entropy_camera_nats: camera.map(|d| d.entropy_nats),
            cluster_size_camera: camera.map(|d| d.cluster_size),
            entropy_world_nats: world.map(|d| d.entropy_nats),
            cluster_size_world: world.map(|d| d.cluster_size),
        }
    }
}

/// One row of Table 1.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RepresentationRow {
    /// Bodies that were reconstructed.
    pub bodies: usize,
    /// Eq. 2.
    pub error: f32,
    /// Eq. 2 and the divergence as a mean over the latent numbers, as the paper's table gives it.
    pub negative_elbo: f32,
    /// The divergence alone, as a mean over the latent numbers, summed over the stages.
    pub divergence: f32,
}

/// Everything that was measured of a method on a set of rooms.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MethodRow {
    /// The method's name in the tables.
    pub method: String,
    /// The set of rooms, such as `test rooms`.
    pub set: String,
    /// The room; `None` for the whole set.
    pub room: Option<String>,
    /// Before or after which fit.
    pub stage: Stage,
    /// The figures; `None` when the method could not run.
    pub figures: Option<PhysicalRow>,
}

/// Table 1's figures of a method.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MethodRepresentation {
    /// The method's name in the tables.
    pub method: String,
    /// On rooms that it was trained on, seen by the agent.
    pub validation: Option<RepresentationRow>,
    /// On test rooms, seen by the agent.
    pub test: Option<RepresentationRow>,
}

/// Why a method has no figures.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Missing {
    /// The method's name in the tables.
    pub method: String,
    /// What it lacks.
    pub why: String,
}

/// What an evaluation found.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Evaluation {
    /// Tables 2 and 3: sets of rooms first, then single rooms.
    pub rows: Vec<MethodRow>,
    /// Table 1.
    pub representation: Vec<MethodRepresentation>,
    /// Methods without figures.
    pub missing: Vec<Missing>,
}

impl Evaluation {
    /// The figures of a method on a whole set at a stage.
    pub fn of_set(&self, method: &str, set: &str, stage: Stage) -> Option<&PhysicalRow> {
        let asked =
            |r: &&MethodRow| r.method == method && r.set == set && r.room.is_none() && r.stage == stage;
        self.rows.iter().find(asked)?.figures.as_ref()
    }

    /// Names of the methods in the order of their rows.
    pub fn methods(&self) -> Vec<&str> {
        distinct(self.rows.iter().map(|r| r.method.as_str()))
    }

    /// Names of the sets of rooms in the order of their rows.
    pub fn sets(&self) -> Vec<&str> {
        distinct(self.rows.iter().map(|r| r.set.as_str()))
    }
}

fn distinct<'a>(names: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let mut found: Vec<&str> = Vec::new();
    for name in names {
        if !found.contains(&name) {
            found.push(name);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_is_the_mean_of_its_bodies() {
        let good =
            BodyMetrics { psi_non_collision: 1.0, contact_2cm: true, supported: true, ..Default::default() };
        let bad = BodyMetrics {
            psi_non_collision: 0.5,
            psi_contact: true,
            penetration_max_mm: 80.0,
            outside_field: 3,
            ..BodyMetrics::default()
        };
        let row = PhysicalRow::of(&[(good, true), (bad, false)], None, None);
        assert_eq!((row.bodies, row.psi_non_collision, row.psi_contact), (2, 0.75, 0.5));
        assert_eq!((row.contact_2cm, row.supported, row.inside, row.faultless), (0.5, 0.5, 0.5, 0.5));
        assert_eq!(row.penetration_max_mm, 40.0);
        assert_eq!(PhysicalRow::of(&[], None, None).psi_contact, 0.0);
    }
}
