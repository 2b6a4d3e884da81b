//! A study with human raters (PSI §4.1.4, LTM §4.3 and ADSE §6 have one each): results of several methods, shown blind
//! and in random order, one by one or in pairs, each scored from 1 to 5; scores as CSV, with mean and standard
//! deviation for each method over all raters.
//!
//! A study is a folder with a folder for each method; in these, projects or rooms of the same names show the same task.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

use super::files::{ProjectError, write_folder};

/// Endings of files that can be shown.
const SHOWN: [&str; 6] = ["inhabit", "ron", "glb", "gltf", "obj", "ply"];
/// What raters' files are called, and the file about all of them.
const SCORES: &str = "scores-";
const SUMMARY: &str = "summary.csv";
/// The header of a rater's file.
const HEADER: &str = "order,place,task,method,score,seconds";

/// One result to be shown.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Exhibit {
    /// What it shows: the same for every method.
    pub task: String,
    /// Who made it; raters don't see it.
    pub method: String,
    /// The file.
    pub path: PathBuf,
}

/// How results are shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum StudyKind {
    /// One after the other.
    #[default]
    Single,
    /// Two of the same task at a time, on sides drawn by chance.
    Pairs,
}

/// What is shown together, and what was thought of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Trial {
    /// One result, or two.
    pub shown: Vec<Exhibit>,
    /// From 1 to 5, for each of them, once given.
    pub scores: Vec<Option<u8>>,
    /// How long the rater looked at it, seconds.
    pub seconds: f32,
}

impl Trial {
    /// Whether everything in it has a score.
    pub fn is_scored(&self) -> bool {
        self.scores.iter().all(Option::is_some)
    }
}

/// A rater's way through a study.
#[derive(Clone, Debug, PartialEq)]
pub struct Study {
    /// Who looks.
    pub rater: String,
    /// In the order in which they are shown.
    pub trials: Vec<Trial>,
}

/// Scores of one method.
#[derive(Clone, Debug, PartialEq)]
pub struct MethodScores {
    /// Who made it.
    pub method: String,
    /// How many scores there are.
    pub count: usize,
    /// Their mean.
    pub mean: f64,
    /// Their standard deviation (n - 1); 0 for a single one.
    pub deviation: f64,
}

impl Study {
    /// Puts exhibits into an order drawn by `seed`. Pairs are all pairs of methods of each task; a task of a single
    /// method is left out of them.
    pub fn plan(rater: &str, exhibits: &[Exhibit], kind: StudyKind, seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut sorted = exhibits.to_vec();
        sorted.sort();
        let mut groups: Vec<Vec<Exhibit>> = match kind {
            StudyKind::Single => sorted.into_iter().map(|one| vec![one]).collect(),
            StudyKind::Pairs => pairs(&sorted),
        };
        groups.iter_mut().for_each(|group| group.shuffle(&mut rng));
        groups.shuffle(&mut rng);
        let trial = |shown: Vec<Exhibit>| Trial { scores: vec![None; shown.len()], shown, seconds: 0.0 };
        Self { rater: rater.trim().to_owned(), trials: groups.into_iter().map(trial).collect() }
    }

    /// How many trials are scored.
    pub fn scored(&self) -> usize {
        self.trials.iter().filter(|trial| trial.is_scored()).count()
    }

    /// A line for each score.
    pub fn csv(&self) -> String {
        let mut text = format!("{HEADER}\n");
        for (order, trial) in self.trials.iter().enumerate() {
            for (place, (exhibit, score)) in trial.shown.iter().zip(&trial.scores).enumerate() {
                let Some(score) = score else { continue };
                let (order, place, seconds) = (order + 1, place + 1, trial.seconds);
                let (task, method) = (quoted(&exhibit.task), quoted(&exhibit.method));
                text.push_str(&format!("{order},{place},{task},{method},{score},{seconds:.1}\n"));
            }
        }
        text
    }
}

fn pairs(sorted: &[Exhibit]) -> Vec<Vec<Exhibit>> {
    let mut groups = Vec::new();
    for (i, one) in sorted.iter().enumerate() {
        let same = sorted[i + 1..].iter().filter(|other| other.task == one.task);
        groups.extend(same.map(|other| vec![one.clone(), other.clone()]));
    }
    groups
}

/// A field of a CSV file (RFC 4180).
fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}

/// The fields of a line without line breaks in them.
fn fields(line: &str) -> Vec<String> {
    let (mut fields, mut inside) = (vec![String::new()], false);
    let mut letters = line.chars().peekable();
    while let Some(letter) = letters.next() {
        let Some(field) = fields.last_mut() else { break };
        match letter {
            '"' if inside && letters.peek() == Some(&'"') => {
                letters.next();
                field.push('"');
            }
            '"' => inside = !inside,
            ',' if !inside => fields.push(String::new()),
            other => field.push(other),
        }
    }
    fields
}

/// Mean and standard deviation of each method in the lines of raters' files.
pub fn summarise<'a>(files: impl IntoIterator<Item = &'a str>) -> Vec<MethodScores> {
    let mut scores: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    for line in files.into_iter().flat_map(|file| file.lines().skip(1)) {
        if let [_, _, _, method, score, ..] = fields(line).as_slice()
            && let Ok(score) = score.parse::<u8>()
        {
            scores.entry(method.clone()).or_default().push(f64::from(score));
        }
    }
    let of = |(method, scores): (String, Vec<f64>)| {
        let (count, mean) = (scores.len(), scores.iter().sum::<f64>() / scores.len() as f64);
        let squares: f64 = scores.iter().map(|score| (score - mean).powi(2)).sum();
        let deviation = if count > 1 { (squares / (count - 1) as f64).sqrt() } else { 0.0 };
        MethodScores { method, count, mean, deviation }
    };
    scores.into_iter().map(of).collect()
}

fn summary_csv(methods: &[MethodScores]) -> String {
    let mut text = "method,scores,mean,standard_deviation\n".to_owned();
    for m in methods {
        text.push_str(&format!("{},{},{:.3},{:.3}\n", quoted(&m.method), m.count, m.mean, m.deviation));
    }
    text
}

/// Everything that a folder has to show.
///
/// # Errors
/// [`ProjectError::Read`] for a folder that can't be read, [`ProjectError::NothingToRate`] for one without methods.
pub fn find_exhibits(folder: &Path) -> Result<Vec<Exhibit>, ProjectError> {
    let refused = |source| ProjectError::Read { file: folder.display().to_string(), source };
    let mut exhibits = Vec::new();
    for method in std::fs::read_dir(folder).map_err(refused)?.flatten().filter(|e| e.path().is_dir()) {
        for file in std::fs::read_dir(method.path()).map_err(refused)?.flatten() {
            let path = file.path();
            let ending = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_lowercase();
            let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            // A project's room lies beside it and is no result by itself.
            if SHOWN.contains(&ending.as_str()) && name != "room" && !name.ends_with(".room") {
                let method = method.file_name().to_string_lossy().into_owned();
                exhibits.push(Exhibit { task: name, method, path });
            }
        }
    }
    exhibits.sort();
    if exhibits.is_empty() {
        return Err(ProjectError::NothingToRate { folder: folder.display().to_string() });
    }
    Ok(exhibits)
}

/// Writes the rater's scores into the study's folder and sums up those of all raters there.
///
/// # Errors
/// [`ProjectError::Write`] and [`ProjectError::Read`].
pub fn save_scores(folder: &Path, study: &Study) -> Result<Vec<MethodScores>, ProjectError> {
    let rater: String = study.rater.chars().map(|c| if c.is_alphanumeric() { c } else { '_' }).collect();
    let name = format!("{SCORES}{}.csv", if rater.is_empty() { "rater" } else { &rater });
    write_folder(folder, &[(name, study.csv().into_bytes())])?;
    let refused = |source| ProjectError::Read { file: folder.display().to_string(), source };
    let mut files = Vec::new();
    for file in std::fs::read_dir(folder).map_err(refused)?.flatten() {
        if file.file_name().to_string_lossy().starts_with(SCORES) {
            files.push(std::fs::read_to_string(file.path()).map_err(refused)?);
        }
    }
    let methods = summarise(files.iter().map(String::as_str));
    write_folder(folder, &[(SUMMARY.to_owned(), summary_csv(&methods).into_bytes())])?;
    Ok(methods)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn exhibits() -> Vec<Exhibit> {
        let one = |task: &str, method: &str| Exhibit {
            task: task.to_owned(),
            method: method.to_owned(),
            path: PathBuf::from(format!("{method}/{task}.inhabit")),
        };
        (0..20)
            .flat_map(|i| [one(&format!("task {i}"), "ours"), one(&format!("task {i}"), "theirs")])
            .collect()
    }

    #[test]
    fn every_result_comes_once_in_an_order_that_only_the_seed_knows() {
        let order = |seed| Study::plan("Ada", &exhibits(), StudyKind::Single, seed).trials;
        assert_eq!(order(1), order(1));
        assert_ne!(order(1), order(2));
        let mut all: Vec<Exhibit> = order(1).into_iter().flat_map(|trial| trial.shown).collect();
        all.sort();
        let mut expected = exhibits();
        expected.sort();
        assert_eq!(all, expected);
    }

    #[test]
    fn a_pair_shows_the_same_task_and_no_side_gives_the_method_away() {
        let study = Study::plan("Ada", &exhibits(), StudyKind::Pairs, 4);
        assert_eq!(study.trials.len(), 20);
        assert!(study.trials.iter().all(|t| t.shown[0].task == t.shown[1].task));
        let left = study.trials.iter().filter(|t| t.shown[0].method == "ours").count();
        assert!((4..=16).contains(&left), "ours is on the left in {left} of 20");
    }

    #[test]
    fn mean_and_deviation_are_those_of_all_raters() {
        let mut study = Study::plan("Ada", &exhibits(), StudyKind::Pairs, 4);
        for (i, trial) in study.trials.iter_mut().enumerate().take(2) {
            for (exhibit, score) in trial.shown.iter().zip(&mut trial.scores) {
                *score = Some(if exhibit.method == "ours" { 5 - i as u8 } else { 2 });
            }
        }
        assert_eq!(study.scored(), 2);
        let other = "order,place,task,method,score,seconds\n1,1,\"a, \"\"b\"\"\",ours,3,1.0\n";
        let methods = summarise([study.csv().as_str(), other]);
        assert_eq!((methods[0].method.as_str(), methods[0].count, methods[0].mean), ("ours", 3, 4.0));
        assert_eq!((methods[0].deviation, methods[1].deviation), (1.0, 0.0));
    }

    #[test]
    fn scores_are_written_beside_those_of_others_and_summed_up() {
        let folder = tempfile::tempdir().unwrap();
        for (method, file) in
            [("ours", "a.inhabit"), ("ours", "room.glb"), ("theirs", "a.inhabit"), ("theirs", "notes.txt")]
        {
            std::fs::create_dir_all(folder.path().join(method)).unwrap();
            std::fs::write(folder.path().join(method).join(file), b"x").unwrap();
        }
        let found = find_exhibits(folder.path()).unwrap();
        assert_eq!(found.len(), 2, "{found:?}");
        for (rater, score) in [("Ada L.", 4), ("Bo", 2)] {
            let mut study = Study::plan(rater, &found, StudyKind::Single, 1);
            study.trials.iter_mut().for_each(|trial| trial.scores = vec![Some(score)]);
            save_scores(folder.path(), &study).unwrap();
        }
        let summary = std::fs::read_to_string(folder.path().join("summary.csv")).unwrap();
        assert_eq!(summary.lines().nth(1), Some("ours,2,3.000,1.414"));
        assert!(folder.path().join("scores-Ada_L_.csv").is_file());
        let empty = tempfile::tempdir().unwrap();
        assert!(find_exhibits(empty.path()).unwrap_err().to_string().contains("a folder for each method"));
    }
}
