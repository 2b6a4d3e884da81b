use serde::{Deserialize, Serialize};

/// Means of one epoch. Terms that did not count are 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MotionRow {
    /// The epoch, from 1.
    pub epoch: usize,
    /// What is learnt by, without divergence, contact and collision: eq. 3 or 4, the sub-goals' reconstruction, or the
    /// points' cross-entropy.
    pub training: f32,
    /// The same on the validation clips, without noise.
    pub validation: f32,
    /// Of the sub-goals: KL divergence, mean over the latent numbers.
    pub divergence: f32,
    /// Of the sub-goals: contact, weighted.
    pub contact: f32,
    /// Of the sub-goals: collision, weighted.
    pub collision: f32,
    /// Validation: mean distance of each coordinate of the pelvis, centimetres.
    pub place_cm: f32,
    /// Validation: mean distance of the rotations' six numbers, times 100.
    pub turn_x100: f32,
    /// Validation: mean distance of the pose codes, times 100.
    pub pose_x100: f32,
    /// Validation, of points: the share labelled rightly.
    pub labelled_rightly: f32,
}

impl MotionRow {
    /// Names and values of all curves.
    pub fn curves(&self) -> [(&'static str, f32); 9] {
        [
            ("training", self.training),
            ("validation", self.validation),
            ("divergence", self.divergence),
            ("contact", self.contact),
            ("collision", self.collision),
            ("place_cm", self.place_cm),
            ("turn_x100", self.turn_x100),
            ("pose_x100", self.pose_x100),
            ("labelled_rightly", self.labelled_rightly),
        ]
    }
}

/// All epochs so far.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MotionHistory {
    /// In order.
    pub rows: Vec<MotionRow>,
    /// The epoch whose numbers are kept: the least validation loss.
    pub best: usize,
}

impl MotionHistory {
    /// Comma-separated: a header, then one line for each epoch.
    pub fn to_csv(&self) -> String {
        let header = MotionRow::default().curves().map(|(name, _)| name).join(",");
        let mut csv = format!("epoch,{header}\n");
        for row in &self.rows {
            let values = row.curves().map(|(_, value)| value.to_string()).join(",");
            csv.push_str(&format!("{},{values}\n", row.epoch));
        }
        csv
    }

    /// The row of the epoch whose numbers are kept.
    pub fn best_row(&self) -> Option<&MotionRow> {
        self.rows.iter().find(|r| r.epoch == self.best)
    }
}
