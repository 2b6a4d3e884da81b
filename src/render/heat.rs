//! The colours of the heat map: what a signed distance looks like, and the ticks of its legend.
//! The one place that fixes them; window, pictures and both renderers read it.

/// Within this distance a body touches what it is near (PSI's contact, and PROX's before it): 2 cm.
pub const CONTACT_M: f32 = 0.02;

/// Where the scale ends on the free side; farther away nothing changes any more.
pub const FREE_END_M: f32 = 0.10;

/// Where the scale ends inside solid things; 50 mm is twice what a good body may show.
pub const DEEP_END_M: f32 = -0.05;

/// Signed distance in metres and sRGB colour, from free space to deep inside. Blue to white to red by way
/// of yellow: blue and yellow-red stay apart for every common colour blindness, and lightness falls off
/// to both sides of contact.
pub const STOPS: [(f32, [u8; 3]); 7] = [
    (FREE_END_M, [42, 74, 138]),
    (0.05, [84, 134, 196]),
    (CONTACT_M, [190, 214, 236]),
    (0.0, [250, 250, 246]),
    (-0.005, [255, 226, 110]),
    (-0.02, [240, 124, 30]),
    (DEEP_END_M, [150, 10, 38]),
];

/// sRGB colour of a signed distance in metres (negative inside something solid). What is not a number is
/// magenta, so that a fault shows.
pub fn heat_color(signed_distance_m: f32) -> [u8; 3] {
    if signed_distance_m.is_nan() {
        return [255, 0, 255];
    }
    let d = signed_distance_m.clamp(DEEP_END_M, FREE_END_M);
    let mut above = STOPS[0];
    for below in STOPS {
        if d >= below.0 {
            let span = above.0 - below.0;
            let t = if span > 0.0 { (above.0 - d) / span } else { 0.0 };
            return std::array::from_fn(|i| {
                let (a, b) = (f32::from(above.1[i]), f32::from(below.1[i]));
                (a + (b - a) * t).round() as u8
            });
        }
        above = below;
    }
    STOPS[STOPS.len() - 1].1
}

/// A mark on the legend.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeatTick {
    /// Signed distance in metres.
    pub distance_m: f32,
    /// What stands beside it.
    pub label: &'static str,
}

/// The marks of the legend, from free space to deep inside.
pub const TICKS: [HeatTick; 6] = [
    HeatTick { distance_m: 0.10, label: "100 mm free" },
    HeatTick { distance_m: 0.05, label: "50 mm" },
    HeatTick { distance_m: 0.02, label: "20 mm contact" },
    HeatTick { distance_m: 0.0, label: "0 mm" },
    HeatTick { distance_m: -0.02, label: "-20 mm inside" },
    HeatTick { distance_m: -0.05, label: "-50 mm" },
];

/// Where a distance stands on the legend's bar: 0 at the free end, 1 at the deep end.
pub fn heat_position(signed_distance_m: f32) -> f32 {
    ((FREE_END_M - signed_distance_m) / (FREE_END_M - DEEP_END_M)).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn free_space_is_blue_contact_is_white_and_penetration_is_red() {
        let [r, _, b] = heat_color(1.0);
        assert!(b > r + 60, "far away has to be blue");
        assert!(heat_color(0.0).iter().all(|c| *c > 235), "touching has to be white");
        let [r, g, b] = heat_color(-0.03);
        assert!(r > g + 80 && r > b + 80, "inside has to be red, is {:?}", heat_color(-0.03));
        let [r, g, b] = heat_color(-0.005);
        assert!(r > b + 80 && g > b + 80, "just inside has to be yellow");
        assert_eq!(heat_color(f32::NAN), [255, 0, 255]);
    }

    #[test]
    fn the_scale_has_no_jumps_and_ends_where_the_legend_ends() {
        let steps = 3000;
        let at = |i: i32| DEEP_END_M + (FREE_END_M - DEEP_END_M) * i as f32 / steps as f32;
        for i in 0..steps {
            let (a, b) = (heat_color(at(i)), heat_color(at(i + 1)));
            assert!(a.iter().zip(b).all(|(a, b)| a.abs_diff(b) <= 3), "jump at {} m: {a:?} {b:?}", at(i));
        }
        assert_eq!(heat_position(TICKS[0].distance_m), 0.0);
        assert_eq!(heat_position(TICKS[TICKS.len() - 1].distance_m), 1.0);
        assert_eq!(heat_color(9.0), heat_color(FREE_END_M));
    }
}
