//! RouteNet, PoseNet, BaseNet and their variants: all of one plan (LTM §3.3, fig. 3b). The two ends go through the
//! LSTM; its outputs, the scene's feature and the route stand side by side; two matrices give all frames at once.

use burn::tensor::Tensor;
use burn::tensor::activation::relu;

use super::config::{BETWEEN, Between, MotionConfig, PLACE};
use super::lstm::BiLstm;
use super::points::PointNet;
use crate::nn::graph::Graph;
use crate::nn::graph::tensor;
use crate::nn::layers::Linear;
use crate::nn::params::Declaration;

/// What such a network is given for a batch.
#[derive(Clone)]
pub struct BetweenInput {
    /// The room's points, `[batch, points, 3]`; not looked at by a network that sees no room.
    pub cloud: Option<Tensor<3>>,
    /// The first bodies, `[batch, ROW]`.
    pub start: Tensor<2>,
    /// The last bodies, `[batch, ROW]`.
    pub end: Tensor<2>,
    /// The routes, `[batch, 60 * 9]`, for PoseNet.
    pub route: Option<Tensor<2>>,
}

#[derive(Clone, Debug)]
pub(super) struct BetweenNet {
    which: Between,
    from_line: bool,
    scene: Option<(PointNet, Linear)>,
    ends: BiLstm,
    route: Option<Linear>,
    wide: Linear,
    out: Linear,
}

impl BetweenNet {
    pub fn declare(d: &mut Declaration, which: Between, config: &MotionConfig, points: &str) -> Self {
        let scene = config.scene.then(|| {
            let net = PointNet::declare(d, points, &config.points);
            (net, Linear::declare(d, "scene", config.points.channels[2], config.scene_lift))
        });
        let route =
            which.takes_route().then(|| Linear::declare(d, "route", BETWEEN * PLACE, config.route_lift));
        let inputs = 4 * config.hidden
            + if scene.is_some() { config.scene_lift } else { 0 }
            + if route.is_some() { config.route_lift } else { 0 };
        Self {
            which,
            from_line: config.from_line,
            scene,
            ends: BiLstm::declare(d, "ends", which.token().len(), config.hidden),
            route,
            wide: Linear::declare(d, "wide", inputs, config.wide),
            out: Linear::declare(d, "out", config.wide, BETWEEN * which.outputs().len()),
        }
    }

    /// `[batch, 60 * outputs]`, frame by frame.
    pub fn forward(&self, g: &Graph, input: &BetweenInput) -> Tensor<2> {
        let token = self.which.token();
        let of = |row: &Tensor<2>| row.clone().narrow(1, token.start, token.len());
        let mut features = vec![self.ends.forward(g, of(&input.start), of(&input.end))];
        if let Some(((net, lift), cloud)) = self.scene.as_ref().zip(input.cloud.clone()) {
            features.push(lift.forward(g, net.forward(g, cloud).whole));
        }
        if let Some((lift, route)) = self.route.as_ref().zip(input.route.clone()) {
            features.push(lift.forward(g, route));
        }
        let made = self.out.forward(g, relu(self.wide.forward(g, Tensor::cat(features, 1))));
        if self.from_line { made + self.line(g, input) } else { made }
    }

    /// The straight line between the two ends, `[batch, 60 * outputs]`.
    fn line(&self, g: &Graph, input: &BetweenInput) -> Tensor<2> {
        let columns = self.which.outputs();
        let batch = input.start.dims()[0];
        let of = |row: &Tensor<2>| {
            row.clone().narrow(1, columns.start, columns.len()).reshape([batch, 1, columns.len()])
        };
        let shares = (1..=BETWEEN).map(|k| k as f32 / (BETWEEN + 1) as f32).collect();
        let shares: Tensor<3> = tensor(shares, [1, BETWEEN, 1], g.device());
        let start = of(&input.start);
        let line = start.clone() + (of(&input.end) - start) * shares;
        line.reshape([batch, BETWEEN * columns.len()])
    }
}
