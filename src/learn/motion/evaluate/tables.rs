use super::rows::{MotionRowKind, MotionStudyRow};

/// Every number of every row, comma-separated.
pub fn motion_csv(rows: &[MotionStudyRow]) -> String {
    let head = "table,method,scene,optimised,seconds,cases,t_l1_x100,r_l1_x100,pose_l1_x100,mpjpe_mm,mpvpe_mm,\
                neighbour_v2v_cm,non_collision_pct,contact_pct,psi_contact_pct,penetration_mean_mm,\
                penetration_max_mm,penetration_worst_mm,collision_frame_share,skate_cm_per_s,skate_frame_share,\
                stance_drift_cm,hover_max_mm,boundary_speed_ratio,jitter_m_per_s3,goal_error_cm,\
                goal_error_deg\n";
    let row = |r: &MotionStudyRow| {
        let (e, m) = (&r.errors, &r.metrics);
        let numbers = [
            e.translation_l1_x100,
            e.orientation_l1_x100,
            e.pose_l1_x100,
            e.mpjpe_mm,
            e.mpvpe_mm,
            r.neighbour_v2v_cm,
            m.non_collision_pct,
            m.contact_pct,
            m.psi_contact_pct,
            m.penetration_mean_mm,
            m.penetration_max_mm,
            r.penetration_worst_mm,
            m.collision_frame_share,
            m.skate_cm_per_s,
            m.skate_frame_share,
            m.stance_drift_cm,
            m.hover_max_mm,
            m.boundary_speed_ratio.unwrap_or(f32::NAN),
            m.jitter_m_per_s3,
            m.goal_error_cm.unwrap_or(f32::NAN),
            m.goal_error_deg.unwrap_or(f32::NAN),
        ];
        let about = format!(
            "{:?},{},{},{},{},{}",
            r.kind,
            r.method.replace(',', " "),
            r.scene,
            r.optimised.label(),
            r.seconds,
            r.cases
        );
        numbers.iter().fold(about, |line, x| format!("{line},{x:.4}")) + "\n"
    };
    head.to_owned() + &rows.iter().map(row).collect::<String>()
}

/// The tables as Markdown, in the order and by the names of the paper's.
pub fn motion_markdown(rows: &[MotionStudyRow]) -> String {
    let of = |kind| rows.iter().filter(|r| r.kind == kind).collect::<Vec<_>>();
    let (short, long) = (of(MotionRowKind::Short), of(MotionRowKind::Long));
    [reconstruction(&short), in_the_room(&short), long_motions(&long)].join("\n")
}

/// How a row says whether its maker sees the room.
fn tick(row: &MotionStudyRow) -> &'static str {
    if row.scene { "✓" } else { "×" }
}

fn reconstruction(rows: &[&MotionStudyRow]) -> String {
    let mut text = String::from(
        "## Reconstruction (LTM Table 1)\n\n\
         | method | scene | optimised | windows | t ×100 | R ×100 | pose ×100 | MPJPE mm | MPVPE mm |\n\
         |---|---|---|---|---|---|---|---|---|\n",
    );
    for r in rows {
        let e = &r.errors;
        text += &format!(
            "| {} | {} | {} | {} | {:.2} | {:.2} | {:.2} | {:.1} | {:.1} |\n",
            r.method,
            tick(r),
            r.optimised.label(),
            r.cases,
            e.translation_l1_x100,
            e.orientation_l1_x100,
            e.pose_l1_x100,
            e.mpjpe_mm,
            e.mpvpe_mm
        );
    }
    text
}

fn in_the_room(rows: &[&MotionStudyRow]) -> String {
    let mut text = String::from(
        "## In the room (LTM Table 2) and neighbour v2v (Table 4)\n\n\
         | method | optimised | windows | non-collision % | contact % | PSI contact % | neighbour v2v cm |\n\
         |---|---|---|---|---|---|---|\n",
    );
    for r in rows {
        let m = &r.metrics;
        text += &format!(
            "| {} {} | {} | {} | {:.2} | {:.2} | {:.2} | {:.2} |\n",
            r.method,
            tick(r),
            r.optimised.label(),
            r.cases,
            m.non_collision_pct,
            m.contact_pct,
            m.psi_contact_pct,
            r.neighbour_v2v_cm
        );
    }
    text
}

fn long_motions(rows: &[&MotionStudyRow]) -> String {
    let some = |x: Option<f32>, digits: usize| x.map_or("-".to_owned(), |x| format!("{x:.digits$}"));
    let mut text = String::from(
        "## Feet, depth, joins and goals\n\n\
         | s | method | optimised | motions | non-collision % | contact % | skate cm/s | drift cm | \
         penetration mean / max / worst mm | boundary speed | jitter m/s³ | neighbour v2v cm | goal error cm, ° |\n\
         |---|---|---|---|---|---|---|---|---|---|---|---|---|\n",
    );
    for r in rows {
        let m = &r.metrics;
        text += &format!(
            "| {} | {} | {} | {} | {:.2} | {:.2} | {:.2} | {:.2} | {:.1} / {:.1} / {:.1} | {} | {:.0} | {:.2} | {}, {} |\n",
            r.seconds,
            r.method,
            r.optimised.label(),
            r.cases,
            m.non_collision_pct,
            m.contact_pct,
            m.skate_cm_per_s,
            m.stance_drift_cm,
            m.penetration_mean_mm,
            m.penetration_max_mm,
            r.penetration_worst_mm,
            some(m.boundary_speed_ratio, 2),
            m.jitter_m_per_s3,
            r.neighbour_v2v_cm,
            some(m.goal_error_cm, 1),
            some(m.goal_error_deg, 1)
        );
    }
    text
}
