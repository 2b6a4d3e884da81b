use serde::{Deserialize, Serialize};

/// Means of one epoch. Terms that did not count are 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct HistoryRow {
    /// The epoch, from 1.
    pub epoch: usize,
    /// Eq. 2 on the training bodies.
    pub reconstruction: f32,
    /// KL divergence, mean over the latent numbers, without its weight; stages summed.
    pub divergence: f32,
    /// Eq. 5, mean squared pose code.
    pub pose_prior: f32,
    /// Eq. 7, weighted.
    pub contact: f32,
    /// Eq. 6, weighted.
    pub collision: f32,
    /// The baseline's cross-entropy of the pose class.
    pub class: f32,
    /// The baseline's discriminator: its own cross-entropy.
    pub discriminator: f32,
    /// Eq. 2 on the validation bodies, with the mean code.
    pub validation_reconstruction: f32,
    /// KL divergence on the validation bodies.
    pub validation_divergence: f32,
}

impl HistoryRow {
    /// Names and values of all curves.
    pub fn curves(&self) -> [(&'static str, f32); 9] {
        [
            ("reconstruction", self.reconstruction),
            ("divergence", self.divergence),
            ("pose_prior", self.pose_prior),
            ("contact", self.contact),
            ("collision", self.collision),
            ("class", self.class),
            ("discriminator", self.discriminator),
            ("validation_reconstruction", self.validation_reconstruction),
            ("validation_divergence", self.validation_divergence),
        ]
    }

    /// Adds the terms of one step.
    pub(super) fn add(&mut self, step: &Self) {
        self.reconstruction += step.reconstruction;
        self.divergence += step.divergence;
        self.pose_prior += step.pose_prior;
        self.contact += step.contact;
        self.collision += step.collision;
        self.class += step.class;
        self.discriminator += step.discriminator;
    }

    /// Sums over `steps` become means.
    pub(super) fn mean_over(&mut self, steps: usize) {
        let share = 1.0 / steps.max(1) as f32;
        for sum in [
            &mut self.reconstruction,
            &mut self.divergence,
            &mut self.pose_prior,
            &mut self.contact,
            &mut self.collision,
            &mut self.class,
            &mut self.discriminator,
        ] {
            *sum *= share;
        }
    }
}

/// All epochs so far.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct History {
    /// In order.
    pub rows: Vec<HistoryRow>,
}

impl History {
    /// Comma-separated: a header, then one line for each epoch.
    pub fn to_csv(&self) -> String {
        let header = HistoryRow::default().curves().map(|(name, _)| name).join(",");
        let mut csv = format!("epoch,{header}\n");
        for row in &self.rows {
            let values = row.curves().map(|(_, value)| value.to_string()).join(",");
            csv.push_str(&format!("{},{values}\n", row.epoch));
        }
        csv
    }
}
