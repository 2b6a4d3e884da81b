//! Builds the tree of many boxes in pieces, so that it can be stopped: obvhs builds in one go and can't be
//! asked. Knows boxes only.

use std::ops::Range;
use std::time::Duration;

use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb as TreeBox;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::bvh2::node::Bvh2Node;
use rayon::prelude::*;

use super::step::{Pace, Step, Stopped, report};

/// Boxes that obvhs gets at once: less than 100 ms of work.
const PIECE: usize = 1 << 16;

/// A part of the boxes, and the node that its tree hangs from.
struct Piece {
    node: usize,
    range: Range<usize>,
}

/// A tree over `boxes`. Large sets are halved at the median until obvhs builds each piece in a moment; the
/// pieces are built side by side and hung below each other. Same tree whatever the number of threads.
///
/// # Errors
/// [`Stopped`] when `step` breaks off.
pub(super) fn tree_of(boxes: &[TreeBox], step: Step) -> Result<Bvh2, Stopped> {
    if boxes.is_empty() {
        return Ok(Bvh2::default());
    }
    let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
    let mut tree = Bvh2 { nodes: vec![Bvh2Node::default()], ..Bvh2::default() };
    let pieces = halve(boxes, &mut order, &mut tree.nodes, step)?;
    let inner = tree.nodes.len();
    let built = pieces.par_iter().enumerate().map(|(done, piece)| {
        report(step, done, pieces.len())?;
        let own: Vec<TreeBox> = order[piece.range.clone()].iter().map(|&i| boxes[i as usize]).collect();
        Ok(build_bvh2(&own, BvhBuildParams::fast_build(), &mut Duration::default()))
    });
    let built = built.collect::<Result<Vec<Bvh2>, Stopped>>()?;
    let deepest = built.iter().map(|own| own.max_depth).max().unwrap_or_default();
    tree.max_depth = deepest + pieces.len().ilog2() as usize + 1;
    for (piece, own) in pieces.iter().zip(&built) {
        report(step, 0, 0)?;
        hang(&mut tree, piece.node, own, &order[piece.range.clone()]);
    }
    // Children stand behind their parents, so boxes grow from the last to the first.
    for index in (0..inner).rev().filter(|&index| pieces.iter().all(|piece| piece.node != index)) {
        let first = tree.nodes[index].first_index as usize;
        let around = tree.nodes[first].aabb().union(tree.nodes[first + 1].aabb());
        tree.nodes[index].set_aabb(around);
    }
    Ok(tree)
}

/// Halves `order` along the longest side until no part is larger than a piece; `nodes`, which holds the root,
/// gets the inner nodes above the pieces and a place for the root of each.
fn halve(
    boxes: &[TreeBox],
    order: &mut [u32],
    nodes: &mut Vec<Bvh2Node>,
    step: Step,
) -> Result<Vec<Piece>, Stopped> {
    let mut pieces = Vec::new();
    let mut open = vec![Piece { node: 0, range: 0..order.len() }];
    while let Some(Piece { node, range }) = open.pop() {
        if range.len() <= PIECE {
            pieces.push(Piece { node, range });
            continue;
        }
        let part = &mut order[range.clone()];
        let mut pace = Pace::new(step, part.len());
        let mut centres = TreeBox::empty();
        for &index in part.iter() {
            pace.item()?;
            centres.extend(boxes[index as usize].center());
        }
        let axis = centres.largest_axis();
        let at = |index: u32| boxes[index as usize].center_axis(axis);
        let middle = part.len() / 2;
        part.select_nth_unstable_by(middle, |&a, &b| at(a).total_cmp(&at(b)).then(a.cmp(&b)));
        let first = nodes.len();
        nodes.extend([Bvh2Node::default(); 2]);
        nodes[node].first_index = first as u32;
        open.push(Piece { node: first + 1, range: range.start + middle..range.end });
        open.push(Piece { node: first, range: range.start..range.start + middle });
    }
    Ok(pieces)
}

/// Hangs the tree of a piece from its node.
fn hang(tree: &mut Bvh2, node: usize, own: &Bvh2, order: &[u32]) {
    // The root takes the node's place; the others follow in pairs, as they stand.
    let nodes = tree.nodes.len() as u32;
    let slots = tree.primitive_indices.len() as u32;
    let mut moved = own.nodes.iter().map(|from| {
        let mut to = *from;
        to.first_index = if from.is_leaf() { from.first_index + slots } else { from.first_index - 1 + nodes };
        to
    });
    if let Some(root) = moved.next() {
        tree.nodes[node] = root;
    }
    tree.nodes.extend(moved);
    tree.primitive_indices.extend(own.primitive_indices.iter().map(|&slot| order[slot as usize]));
}
