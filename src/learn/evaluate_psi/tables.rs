//! The rows as text: Markdown like the paper's tables, and CSV.

use std::fmt::Write as _;

use super::rows::{Evaluation, MethodRow, PhysicalRow, RepresentationRow, Stage};

/// A column of a table: its heading, its figure, how many digits, and whether a larger figure is better.
struct Column {
    heading: &'static str,
    value: fn(&PhysicalRow) -> Option<f32>,
    digits: usize,
    best: Best,
}

/// Which figure of a column is printed in boldface.
#[derive(Clone, Copy, PartialEq)]
enum Best {
    Largest,
    Smallest,
}

const fn column(
    heading: &'static str,
    value: fn(&PhysicalRow) -> Option<f32>,
    digits: usize,
    best: Best,
) -> Column {
    Column { heading, value, digits, best }
}

const TABLE_2: [Column; 4] = [
    column("entropy, camera", |r| r.entropy_camera_nats, 2, Best::Largest),
    column("cluster size, camera", |r| r.cluster_size_camera, 2, Best::Largest),
    column("entropy, world", |r| r.entropy_world_nats, 2, Best::Largest),
    column("cluster size, world", |r| r.cluster_size_world, 2, Best::Largest),
];
const TABLE_3: [Column; 2] = [
    column("non-collision (PSI)", |r| Some(r.psi_non_collision), 3, Best::Largest),
    column("contact (PSI)", |r| Some(r.psi_contact), 2, Best::Largest),
];
const TABLE_3_STRICT: [Column; 5] = [
    column("contact within 2 cm", |r| Some(r.contact_2cm), 2, Best::Largest),
    column("deepest penetration, mm", |r| Some(r.penetration_max_mm), 0, Best::Smallest),
    column("held", |r| Some(r.supported), 2, Best::Largest),
    column("inside the room", |r| Some(r.inside), 2, Best::Largest),
    column("without findings", |r| Some(r.faultless), 2, Best::Largest),
];

impl Evaluation {
    /// Tables 1, 2 and 3, the stricter measures and the rooms one by one, as Markdown.
    pub fn markdown(&self) -> String {
        let mut text = String::new();
        if !self.representation.is_empty() {
            text += "## Table 1: representation\n\n";
            text += &self.table_1();
        }
        text += "\n## Table 2: diversity\n\n";
        text += &self.table(&TABLE_2);
        text += "\n## Table 3: physical plausibility\n\n";
        text += &self.table(&TABLE_3);
        text += "\n## Table 3, stricter measures\n\n";
        text += &self.table(&TABLE_3_STRICT);
        for missing in &self.missing {
            let _ = write!(text, "\n{} has no figures: {}\n", missing.method, missing.why);
        }
        text += "\n## Room by room\n\n";
        text += &self.rooms();
        text
    }

    fn table_1(&self) -> String {
        let mut text = String::from(
            "| model | rec. err. val | rec. err. test | -log P(x) val | -log P(x) test | divergence val | divergence test | bodies |\n|---|---|---|---|---|---|---|---|\n",
        );
        for row in &self.representation {
            let cell = |of: &Option<RepresentationRow>, value: fn(&RepresentationRow) -> f32| {
                of.as_ref().map_or_else(|| "-".to_owned(), |r| format!("{:.3}", value(r)))
            };
            let both = |value: fn(&RepresentationRow) -> f32| {
                format!("{} | {}", cell(&row.validation, value), cell(&row.test, value))
            };
            let count = |of: &Option<RepresentationRow>| of.as_ref().map_or(0, |r| r.bodies);
            let _ = writeln!(
                text,
                "| {} | {} | {} | {} | {} + {} |",
                row.method,
                both(|r| r.error),
                both(|r| r.negative_elbo),
                both(|r| r.divergence),
                count(&row.validation),
                count(&row.test)
            );
        }
        text
    }

    /// Methods and stages down, the columns of every set across; the best of each column in boldface.
    fn table(&self, columns: &[Column]) -> String {
        let sets = self.sets();
        let headings = columns.iter().flat_map(|c| sets.iter().map(move |s| format!("{}, {s}", c.heading)));
        let headings: Vec<String> = headings.collect();
        let mut text = format!("| model | {} | bodies |\n", headings.join(" | "));
        let _ = writeln!(text, "|---|{}---|", "---|".repeat(headings.len()));
        for stage in Stage::ALL {
            for method in self.methods() {
                let figures: Vec<Option<&PhysicalRow>> =
                    sets.iter().map(|s| self.of_set(method, s, stage)).collect();
                let cell = |c: &Column, i: usize| {
                    let value = (c.value)(figures[i]?)?;
                    let number = format!("{value:.*}", c.digits);
                    Some(if self.is_best(c, sets[i], value) { format!("**{number}**") } else { number })
                };
                let cells = columns.iter().flat_map(|c| (0..sets.len()).map(move |i| (c, i)));
                let cells: Vec<String> = cells.map(|(c, i)| cell(c, i).unwrap_or("-".into())).collect();
                let bodies: Vec<String> =
                    figures.iter().map(|f| f.map_or(0, |f| f.bodies).to_string()).collect();
                let (cells, bodies) = (cells.join(" | "), bodies.join(" + "));
                let _ = writeln!(text, "| {method}{} | {cells} | {bodies} |", stage.suffix());
            }
        }
        text
    }

    /// Whether no method at any stage has a better figure on this set, to the digits that are printed.
    fn is_best(&self, column: &Column, set: &str, value: f32) -> bool {
        let of_set = self.rows.iter().filter(|r| r.set == set && r.room.is_none());
        let others =
            of_set.filter_map(|r| r.figures.as_ref()).filter(|f| f.bodies > 0).filter_map(column.value);
        let scale = 10f32.powi(column.digits as i32);
        let rounded = |v: f32| (v * scale).round();
        others.into_iter().all(|other| match column.best {
            Best::Largest => rounded(value) >= rounded(other),
            Best::Smallest => rounded(value) <= rounded(other),
        })
    }

    fn rooms(&self) -> String {
        let mut text = String::from(
            "| room | model | bodies | non-collision (PSI) | contact (PSI) | contact within 2 cm | deepest penetration, mm | held | without findings | entropy, world |\n|---|---|---|---|---|---|---|---|---|---|\n",
        );
        for row in self.rows.iter().filter(|r| r.room.is_some()) {
            let (Some(room), Some(f)) = (&row.room, &row.figures) else { continue };
            let _ = writeln!(
                text,
                "| {room} | {}{} | {} | {:.3} | {:.2} | {:.2} | {:.0} | {:.2} | {:.2} | {} |",
                row.method,
                row.stage.suffix(),
                f.bodies,
                f.psi_non_collision,
                f.psi_contact,
                f.contact_2cm,
                f.penetration_max_mm,
                f.supported,
                f.faultless,
                f.entropy_world_nats.map_or("-".to_owned(), |nats| format!("{nats:.2}"))
            );
        }
        text
    }

    /// Tables 2 and 3 and the rooms as comma-separated values: one line a method, stage and room; an empty room
    /// stands for the whole set, empty figures for a method that could not run.
    pub fn csv(&self) -> String {
        let mut text = String::from(
            "set,room,method,stage,bodies,psi_non_collision,psi_contact,contact_2cm,penetration_max_mm,supported,inside,faultless,contact_area_cm2,diverse_bodies,entropy_camera_nats,cluster_size_camera,entropy_world_nats,cluster_size_world\n",
        );
        self.rows.iter().for_each(|row| text += &csv_line(row));
        text
    }

    /// Table 1 as comma-separated values.
    pub fn representation_csv(&self) -> String {
        let mut text = String::from("method,split,bodies,error,negative_elbo,divergence\n");
        for row in &self.representation {
            for (split, found) in [("validation", &row.validation), ("test", &row.test)] {
                let _ = match found {
                    Some(f) => writeln!(
                        text,
                        "{},{split},{},{},{},{}",
                        row.method, f.bodies, f.error, f.negative_elbo, f.divergence
                    ),
                    None => writeln!(text, "{},{split},0,,,", row.method),
                };
            }
        }
        text
    }
}

fn csv_line(row: &MethodRow) -> String {
    let quoted = |name: &str| match name.contains([',', '"']) {
        true => format!("\"{}\"", name.replace('"', "\"\"")),
        false => name.to_owned(),
    };
    let room = quoted(row.room.as_deref().unwrap_or(""));
    let figures = row.figures.as_ref().map_or_else(
        || "0".to_owned() + &",".repeat(13),
        |f| {
            let PhysicalRow { bodies, diverse_bodies, .. } = f;
            let number = |value: Option<f32>| value.map_or(String::new(), |v| v.to_string());
            format!(
                "{bodies},{},{},{},{},{},{},{},{},{diverse_bodies},{},{},{},{}",
                f.psi_non_collision,
                f.psi_contact,
                f.contact_2cm,
                f.penetration_max_mm,
                f.supported,
                f.inside,
                f.faultless,
                f.contact_area_cm2,
                number(f.entropy_camera_nats),
                number(f.cluster_size_camera),
                number(f.entropy_world_nats),
                number(f.cluster_size_world)
            )
        },
    );
    let stage = match row.stage {
        Stage::Before => "before",
        Stage::PublishedFit => "published_fit",
        Stage::OurFit => "our_fit",
    };
    format!("{},{room},{},{stage},{figures}\n", quoted(&row.set), quoted(&row.method))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::learn::evaluate_psi::rows::{MethodRepresentation, Missing};

    fn row(method: &str, stage: Stage, free: Option<f32>) -> MethodRow {
        let figures = |free| PhysicalRow { bodies: 10, psi_non_collision: free, ..PhysicalRow::default() };
        MethodRow {
            method: method.into(),
            set: "test rooms".into(),
            room: None,
            stage,
            figures: free.map(figures),
        }
    }

    fn evaluation() -> Evaluation {
        Evaluation {
            rows: vec![
                row("S1", Stage::Before, Some(0.9)),
                row("S2", Stage::Before, None),
                row("S1", Stage::OurFit, Some(0.994)),
            ],
            representation: vec![MethodRepresentation {
                method: "S1".into(),
                validation: None,
                test: Some(RepresentationRow {
                    bodies: 4,
                    error: 0.25,
                    negative_elbo: 0.41,
                    divergence: 0.16,
                }),
            }],
            missing: vec![Missing { method: "S2".into(), why: "no weights".into() }],
        }
    }

    #[test]
    fn the_best_figure_is_bold_and_a_method_without_weights_says_so() {
        let text = evaluation().markdown();
        assert!(text.contains("| S1 | 0.900 |"), "{text}");
        assert!(text.contains("| S1 + our fit | **0.994** |"), "{text}");
        assert!(text.contains("| S2 | - | - | 0 |"), "{text}");
        assert!(text.contains("S2 has no figures: no weights"), "{text}");
        assert!(text.contains("| S1 | - | 0.250 | - | 0.410 | - | 0.160 | 0 + 4 |"), "{text}");
    }

    #[test]
    fn every_line_of_the_csv_has_as_many_fields_as_its_heading() {
        for text in [evaluation().csv(), evaluation().representation_csv()] {
            let fields: Vec<usize> = text.lines().map(|l| l.split(',').count()).collect();
            assert!(fields.iter().all(|n| *n == fields[0]), "{text}");
        }
    }
}
