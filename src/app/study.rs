//! The study mode: results of several methods, shown blind and in random order, scored by key. While it runs the
//! user's own room waits untouched.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use egui::Key;

use super::actions;
use super::engine::{ImportChoice, Opened, Source};
use super::state::{EditorState, Overlay};
use crate::document::Document;
use crate::document::MethodScores;
use crate::document::Study;
use crate::document::StudyKind;
use crate::document::find_exhibits;
use crate::document::save_scores;
use crate::job::{Job, JobCtx, Seed, Stop};
use crate::scene::Scene;

/// What the next study is.
#[derive(Clone, Debug, PartialEq)]
pub struct StudySetup {
    /// A folder with a folder for each method.
    pub folder: String,
    /// Who looks.
    pub rater: String,
    /// How results are shown.
    pub kind: StudyKind,
    /// What is asked of each.
    pub question: String,
    /// Chooses the order.
    pub seed: u64,
}

impl Default for StudySetup {
    fn default() -> Self {
        Self {
            folder: String::new(),
            rater: String::new(),
            kind: StudyKind::Single,
            question: "How natural does this look?".to_owned(),
            seed: 1,
        }
    }
}

/// A study under way.
pub struct StudyRun {
    /// What is asked.
    pub question: String,
    /// What is shown and what was thought of it.
    pub study: Study,
    /// The trial that is shown.
    pub at: usize,
    /// Which of its results is shown.
    pub side: usize,
    /// The methods' scores over all raters; raters see them at the end.
    pub summary: Vec<MethodScores>,
    folder: PathBuf,
    shown: Option<PathBuf>,
    loaded: BTreeMap<PathBuf, Scene>,
    opening: Option<(PathBuf, Job<Opened>)>,
    saving: Option<Job<Vec<MethodScores>>>,
    /// How many times scores were given to be written; held while they are.
    writings: Arc<(AtomicUsize, Mutex<()>)>,
    since: Instant,
    /// The user's own document and its file.
    waiting: (Document, Option<PathBuf>),
}

impl StudyRun {
    /// Whether there is nothing left to score.
    pub fn is_done(&self) -> bool {
        self.at >= self.study.trials.len()
    }

    /// Whether what is to be looked at is there.
    pub fn is_shown(&self) -> bool {
        self.shown.is_some() && self.shown == self.wanted()
    }

    fn wanted(&self) -> Option<PathBuf> {
        Some(self.study.trials.get(self.at)?.shown.get(self.side)?.path.clone())
    }

    /// What is worth reading next: what is shown, else the other result of the trial.
    fn to_read(&self) -> Option<PathBuf> {
        let trial = self.study.trials.get(self.at)?;
        let missing = |path: &PathBuf| !self.loaded.contains_key(path);
        let others = trial.shown.iter().map(|exhibit| exhibit.path.clone());
        self.wanted().into_iter().chain(others).find(missing)
    }
}

impl EditorState {
    /// Begins the study that was set up.
    pub fn start_study(&mut self) {
        let setup = self.study_setup.clone();
        let folder = PathBuf::from(setup.folder.trim());
        let exhibits = match find_exhibits(&folder) {
            Ok(exhibits) => exhibits,
            Err(error) => return self.notices.error("The study can't begin", error.to_string()),
        };
        let study = Study::plan(&setup.rater, &exhibits, setup.kind, setup.seed);
        if study.trials.is_empty() {
            let why = "No task has results of two methods. Give files of the same task the same name.";
            return self.notices.error("The study can't begin", why.to_owned());
        }
        self.cancel_all();
        self.overlay = Overlay::None;
        let waiting = (std::mem::take(&mut self.document), self.project.take());
        self.exchange_document(Document::default());
        self.study = Some(StudyRun {
            question: setup.question,
            study,
            at: 0,
            side: 0,
            summary: Vec::new(),
            folder,
            shown: None,
            loaded: BTreeMap::new(),
            opening: None,
            saving: None,
            writings: Arc::default(),
            since: Instant::now(),
            waiting,
        });
    }

    /// Ends the study; the user's own room is there again. Scores are in the folder already.
    pub fn leave_study(&mut self) {
        let Some(run) = self.study.take() else { return };
        let (document, project) = run.waiting;
        self.exchange_document(document);
        self.project = project;
        self.motion.forget();
        self.prune();
        actions::home_view(self);
        self.notices.info(format!("Scores are in {}", run.folder.display()));
    }

    /// Scores what is shown, from 1 to 5, and goes on.
    pub fn score(&mut self, score: u8) {
        let Some(run) = self.study.as_mut().filter(|run| run.is_shown()) else { return };
        let (at, side) = (run.at, run.side);
        let Some(trial) = run.study.trials.get_mut(at) else { return };
        trial.scores[side] = Some(score.clamp(1, 5));
        match trial.scores.iter().position(Option::is_none) {
            Some(open) => run.side = open,
            None => {
                trial.seconds += run.since.elapsed().as_secs_f32();
                self.keep_scores();
                self.go_to_trial(at + 1);
            }
        }
    }

    /// Shows the other result of a pair.
    pub fn show_side(&mut self, side: usize) {
        if let Some(run) = &mut self.study {
            let sides = run.study.trials.get(run.at).map_or(0, |trial| trial.shown.len());
            run.side = side.min(sides.saturating_sub(1));
        }
    }

    /// Goes back to the trial before, to score it again.
    pub fn previous_trial(&mut self) {
        if let Some(at) = self.study.as_ref().and_then(|run| run.at.checked_sub(1)) {
            self.go_to_trial(at);
        }
    }

    fn go_to_trial(&mut self, at: usize) {
        let Some(run) = &mut self.study else { return };
        (run.at, run.side, run.since) = (at, 0, Instant::now());
        let kept: Vec<PathBuf> =
            run.study.trials.get(at).into_iter().flat_map(|t| &t.shown).map(|e| e.path.clone()).collect();
        run.loaded.retain(|path, _| kept.contains(path));
    }

    /// Writes all scores in the background, one writing at a time; what has newer ones behind it is left out, and the
    /// newest is written even if the study is left meanwhile.
    fn keep_scores(&mut self) {
        let waker = self.waker();
        let Some(run) = &mut self.study else { return };
        let (folder, study, writings) = (run.folder.clone(), run.study.clone(), run.writings.clone());
        let number = writings.0.fetch_add(1, Ordering::Relaxed) + 1;
        let keep = move |_: &JobCtx| {
            let _turn = writings.1.lock().unwrap_or_else(PoisonError::into_inner);
            if writings.0.load(Ordering::Relaxed) > number {
                return Err(Stop::Cancelled);
            }
            Ok(save_scores(&folder, &study)?)
        };
        run.saving = Some(Job::spawn("Keep scores", Seed::root(0), waker, keep));
    }

    /// A key while a study runs; whether it meant anything there.
    pub fn key_in_study(&mut self, key: Key) -> bool {
        if self.study.is_none() || self.overlay != Overlay::None {
            return false;
        }
        let numbers = [Key::Num1, Key::Num2, Key::Num3, Key::Num4, Key::Num5];
        match key {
            Key::A | Key::ArrowLeft => self.show_side(0),
            Key::B | Key::ArrowRight => self.show_side(1),
            Key::Backspace => self.previous_trial(),
            Key::Escape => self.leave_study(),
            Key::Space | Key::Home | Key::C => return false,
            _ => {
                if let Some(number) = numbers.iter().position(|number| *number == key) {
                    self.score(number as u8 + 1);
                }
            }
        }
        true
    }

    pub(super) fn poll_study(&mut self) {
        self.poll_study_saving();
        self.poll_study_opening();
        let waker = self.waker();
        let engine = self.engine.clone();
        let Some(run) = &mut self.study else { return };
        if run.opening.is_none()
            && let Some(path) = run.to_read()
        {
            let source = Source::File(path.clone(), ImportChoice::default());
            let work = move |cx: &JobCtx| engine.open(&source, cx.ticker());
            run.opening = Some((path, Job::spawn("Open a result", Seed::root(0), waker, work)));
        }
        let wanted = run.wanted().filter(|path| run.shown.as_ref() != Some(path));
        let scene = wanted.as_ref().and_then(|path| run.loaded.get(path).cloned());
        if let Some((path, scene)) = wanted.zip(scene) {
            self.show_exhibit(path, scene);
        }
    }

    fn show_exhibit(&mut self, path: PathBuf, scene: Scene) {
        let first = self.study.as_ref().is_some_and(|run| run.shown.is_none());
        self.exchange_document(Document::new(scene));
        self.selection.clear();
        self.motion.forget();
        self.motion.player.playing = self.can_play();
        if let Some(run) = &mut self.study {
            run.shown = Some(path);
        }
        if first {
            actions::home_view(self);
            self.orbit.arrive();
        }
    }

    fn poll_study_opening(&mut self) {
        let Some((_, job)) = self.study.as_mut().and_then(|run| run.opening.as_mut()) else { return };
        let Some(outcome) = job.poll() else { return };
        let Some((path, _)) = self.study.as_mut().and_then(|run| run.opening.take()) else { return };
        // What the file is called must not be said: it may name the method.
        match self.taken("A result of the study", outcome) {
            Some(opened) => {
                if let Some(run) = &mut self.study {
                    run.loaded.insert(path, opened.scene);
                }
            }
            None => self.leave_study(),
        }
    }

    fn poll_study_saving(&mut self) {
        let Some(job) = self.study.as_mut().and_then(|run| run.saving.as_mut()) else { return };
        let Some(outcome) = job.poll() else { return };
        if let Some(run) = &mut self.study {
            run.saving = None;
        }
        if let Some(summary) = self.taken("Keep scores", outcome)
            && let Some(run) = &mut self.study
        {
            run.summary = summary;
        }
    }
}
