use crate::body::Region;
use crate::scene::PoseFamily;

/// A region that should touch the room.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactGoal {
    /// Which region.
    pub region: Region,
    /// Its weight among the goals.
    pub weight: f32,
    /// A gap wider than this pulls ever less: feet that don't reach the floor dangle.
    pub reach_m: f32,
}

const fn goal(region: Region, weight: f32, reach_m: f32) -> ContactGoal {
    ContactGoal { region, weight, reach_m }
}

/// What each pose family rests on. Seats and beds carry (weight 1 and more); backs, arms and heads rest where
/// something is near.
pub fn contact_goals(family: PoseFamily) -> &'static [ContactGoal] {
    use Region::{Back, Butt, Calves, Forearms, Front, HeadBack, Heels, LeftHand, LeftLeg, LeftSide};
    use Region::{LegFronts, RightHand, RightLeg, RightSide, Thighs};
    const FEET: (ContactGoal, ContactGoal) = (goal(LeftLeg, 0.5, 0.12), goal(RightLeg, 0.5, 0.12));
    match family {
        PoseFamily::Stand => const { &[goal(LeftLeg, 2.0, 0.3), goal(RightLeg, 2.0, 0.3)] },
        PoseFamily::Lean => {
            const {
                &[
                    goal(LeftLeg, 2.0, 0.3),
                    goal(RightLeg, 2.0, 0.3),
                    goal(LeftHand, 0.4, 0.08),
                    goal(RightHand, 0.4, 0.08),
                    goal(Butt, 0.3, 0.06),
                    goal(Back, 0.3, 0.06),
                ]
            }
        }
        PoseFamily::SitChair | PoseFamily::SitSofa => {
            const { &[goal(Butt, 2.0, 0.3), goal(Thighs, 1.0, 0.1), goal(Back, 0.4, 0.06), FEET.0, FEET.1] }
        }
        PoseFamily::SitStool | PoseFamily::SitEdge => {
            const { &[goal(Butt, 2.0, 0.3), goal(Thighs, 1.0, 0.1), FEET.0, FEET.1] }
        }
        PoseFamily::SitStraight => {
            const { &[goal(Butt, 2.0, 0.3), goal(Thighs, 0.5, 0.1), goal(Calves, 1.0, 0.2), goal(Back, 0.3, 0.06)] }
        }
        PoseFamily::LieUp => {
            const {
                &[
                    goal(Back, 2.0, 0.3),
                    goal(Butt, 2.0, 0.3),
                    goal(Heels, 0.6, 0.12),
                    goal(HeadBack, 0.6, 0.12),
                    goal(Forearms, 0.2, 0.06),
                ]
            }
        }
        PoseFamily::LieDown => {
            const { &[goal(Front, 2.0, 0.3), goal(LegFronts, 1.0, 0.12), goal(Forearms, 0.3, 0.1)] }
        }
        PoseFamily::LieSide => {
            const { &[goal(LeftSide, 1.5, 0.15), goal(RightSide, 1.5, 0.15), goal(Thighs, 0.3, 0.1)] }
        }
    }
}
