//! The networks of motion that come with the program, and what is made of them.

use std::sync::OnceLock;

use super::learned::{LearnedMotion, LearnedMotionError};
use crate::assets::{Weights, WeightsError};

/// Name and bytes of each file.
const FILES: [(&str, &[u8]); 3] = [
    ("route", include_bytes!("../../assets/networks/motion_route.safetensors")),
    ("pose", include_bytes!("../../assets/networks/motion_pose.safetensors")),
    ("subgoal", include_bytes!("../../assets/networks/motion_subgoal.safetensors")),
];

/// RouteNet, PoseNet and the sub-goal network that come with the program.
///
/// # Errors
/// Never with the embedded files, which a test reads.
pub fn bundled_networks() -> impl Iterator<Item = Result<Weights, WeightsError>> {
    FILES.iter().map(|(name, bytes)| Weights::from_bytes(&format!("bundled {name}"), bytes))
}

impl LearnedMotion {
    /// The networks that come with the program; read once.
    ///
    /// # Errors
    /// Never with the embedded files, which a test reads.
    pub fn bundled() -> Result<&'static Self, LearnedMotionError> {
        static NETS: OnceLock<LearnedMotion> = OnceLock::new();
        if let Some(nets) = NETS.get() {
            return Ok(nets);
        }
        let files: Vec<Weights> = bundled_networks().collect::<Result<_, _>>()?;
        let nets = Self::from_weights(&files[0], &files[1])?;
        Ok(NETS.get_or_init(|| nets))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nn::motion::MotionSampler;

    #[test]
    fn the_networks_that_come_with_the_program_are_what_their_names_say() {
        assert!(LearnedMotion::bundled().is_ok());
        let labels: Vec<&str> = bundled_networks()
            .map(|w| {
                MotionSampler::from_weights(&w.expect("a file")).expect("a network").config().kind.label()
            })
            .collect();
        assert_eq!(labels, FILES.map(|(name, _)| name));
    }
}
