//! A bidirectional LSTM (Hochreiter and Schmidhuber 1997) over two tokens: LTM runs it over the two ends alone.

use burn::tensor::Tensor;
use burn::tensor::activation::{sigmoid, tanh};

use crate::nn::graph::Graph;
use crate::nn::params::{Declaration, Init, ParamId, Role};

/// One layer, two directions.
#[derive(Clone, Debug)]
pub(super) struct BiLstm {
    directions: [Cell; 2],
}

#[derive(Clone, Copy, Debug)]
struct Cell {
    input: ParamId,
    recurrent: ParamId,
    bias: ParamId,
    hidden: usize,
}

impl BiLstm {
    pub fn declare(d: &mut Declaration, name: &str, inputs: usize, hidden: usize) -> Self {
        let directions =
            ["forward", "backward"].map(|way| Cell::declare(d, &format!("{name}.{way}"), inputs, hidden));
        Self { directions }
    }

    /// Two tokens `[batch, inputs]` to the outputs of both directions at both, `[batch, 4 hidden]`.
    pub fn forward(&self, g: &Graph, start: Tensor<2>, end: Tensor<2>) -> Tensor<2> {
        let [ahead, back] = &self.directions;
        let [ahead_at_start, ahead_at_end] = ahead.run(g, start.clone(), end.clone());
        let [back_at_end, back_at_start] = back.run(g, end, start);
        Tensor::cat(vec![ahead_at_start, back_at_start, ahead_at_end, back_at_end], 1)
    }
}

impl Cell {
    /// Even start within 1/sqrt(hidden), PyTorch's default.
    fn declare(d: &mut Declaration, name: &str, inputs: usize, hidden: usize) -> Self {
        let init = Init::Uniform(1.0 / (hidden as f32).sqrt());
        let mut add =
            |part: &str, shape: &[usize]| d.add(&format!("{name}.{part}"), shape, init, Role::Trained);
        Self {
            input: add("input", &[inputs, 4 * hidden]),
            recurrent: add("recurrent", &[hidden, 4 * hidden]),
            bias: add("bias", &[4 * hidden]),
            hidden,
        }
    }

    /// The outputs at the first and the second token, from an empty state.
    fn run(&self, g: &Graph, first: Tensor<2>, second: Tensor<2>) -> [Tensor<2>; 2] {
        let bias = || g.param::<1>(self.bias).reshape([1, 4 * self.hidden]);
        let (state, output) = self.step(&(first.matmul(g.param::<2>(self.input)) + bias()), None);
        let gates = second.matmul(g.param::<2>(self.input))
            + output.clone().matmul(g.param::<2>(self.recurrent))
            + bias();
        let (_, last) = self.step(&gates, Some(state));
        [output, last]
    }

    /// State and output after the gates, which stand in the order input, forget, candidate, output.
    fn step(&self, gates: &Tensor<2>, state: Option<Tensor<2>>) -> (Tensor<2>, Tensor<2>) {
        let gate = |i: usize| gates.clone().narrow(1, i * self.hidden, self.hidden);
        let fresh = sigmoid(gate(0)) * tanh(gate(2));
        let state = match state {
            Some(before) => sigmoid(gate(1)) * before + fresh,
            None => fresh,
        };
        (state.clone(), sigmoid(gate(3)) * tanh(state))
    }
}
