//! The study as Markdown, CSV and JSON.

use crate::learn::estimation::{CaseResult, ObserveConfig, Summary};

/// What is written as JSON.
#[derive(serde::Serialize)]
pub struct Report<'a> {
    /// Always `evaluate estimation`.
    pub command: &'static str,
    /// Version of the program.
    pub version: &'static str,
    /// Root of the seed tree.
    pub seed: u64,
    /// Who said what people do in a scene.
    pub scene_prior: &'static str,
    /// How keypoints were made.
    pub keypoints: ObserveConfig,
    /// Means, comparisons, worst cases.
    pub summary: &'a Summary,
    /// Every case.
    pub cases: &'a [CaseResult],
}

/// The tables for people.
pub fn markdown(summary: &Summary) -> String {
    let mut text = format!(
        "{} views in {} rooms; millimetres, means over views.\n\n| method | PJE | V2V | p.PJE | p.V2V | keypoints, px |\n\
         |---|---|---|---|---|---|\n",
        summary.cases, summary.rooms
    );
    for row in &summary.methods {
        let e = &row.errors;
        text += &format!(
            "| {} | {:.1} | {:.1} | {:.1} | {:.1} | {:.1} |\n",
            row.method, e.pje_mm, e.v2v_mm, e.aligned_pje_mm, e.aligned_v2v_mm, row.reprojection_px
        );
    }
    text += "\n| difference | mean, mm | 95 % interval | better in |\n|---|---|---|---|\n";
    for c in &summary.comparisons {
        text += &format!(
            "| {} | {:+.1} | {:+.1} to {:+.1} | {:.0} % |\n",
            c.what,
            c.mean_mm,
            c.low_mm,
            c.high_mm,
            c.better_share * 100.0
        );
    }
    text += &groups_and_worst(summary);
    text
}

fn groups_and_worst(summary: &Summary) -> String {
    let mut text =
        String::from("\n| V2V of people who | views | SMPLify-X | PROX | ours |\n|---|---|---|---|---|\n");
    for group in &summary.groups {
        let errors: String = group.v2v_mm.iter().map(|v| format!(" {v:.1} |")).collect();
        text += &format!("| {} | {} |{errors}\n", group.group, group.cases);
    }
    text +=
        "\n| worst of ours | does | keypoints | V2V: SMPLify-X | PROX | ours |\n|---|---|---|---|---|---|\n";
    for case in &summary.worst {
        let errors: String = case.errors.iter().map(|e| format!(" {:.0} |", e.v2v_mm)).collect();
        text += &format!(
            "| {}, view {} | {} | {} |{errors}\n",
            case.room,
            case.number,
            case.family.label(),
            case.points
        );
    }
    text
}

/// One line a view.
pub fn csv(results: &[CaseResult]) -> String {
    let mut text = String::from("room,view,family,keypoints,depth_m");
    for method in ["smplify_x", "prox", "ours"] {
        for error in ["pje_mm", "v2v_mm", "p_pje_mm", "p_v2v_mm", "reprojection_px"] {
            text += &format!(",{method}_{error}");
        }
    }
    text += "\n";
    for case in results {
        let room = case.room.replace(['"', ','], "_");
        text +=
            &format!("{room},{},{},{},{:.3}", case.number, case.family.label(), case.points, case.depth_m);
        for (e, px) in case.errors.iter().zip(&case.reprojection_px) {
            text += &format!(
                ",{:.2},{:.2},{:.2},{:.2},{px:.2}",
                e.pje_mm, e.v2v_mm, e.aligned_pje_mm, e.aligned_v2v_mm
            );
        }
        text += "\n";
    }
    text
}
