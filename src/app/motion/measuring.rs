//! Measures motions beside the window, so that the timeline can show where they are at fault.

use std::sync::Arc;

use crate::app::state::EditorState;
use crate::document::RoomVersion;
use crate::inspect::Finding;
use crate::inspect::MotionLimits;
use crate::inspect::MotionReport;
use crate::job::{Job, JobCtx, Seed};
use crate::scene::Clip;

/// What was measured: valid for exactly these frames in exactly this room.
#[derive(Clone, Debug)]
pub struct MeasuredClip {
    clip: Arc<Clip>,
    version: RoomVersion,
    /// The numbers.
    pub report: Arc<MotionReport>,
}

impl MeasuredClip {
    /// Whether it still says something about `clip`.
    pub fn holds(&self, clip: &Arc<Clip>, version: RoomVersion) -> bool {
        let same = Arc::ptr_eq(&self.clip, clip) || self.clip.frames == clip.frames;
        version == self.version && same && self.clip.betas == clip.betas
    }
}

/// A measurement that runs.
pub struct Measuring {
    pub job: Job<MotionReport>,
    clip: Arc<Clip>,
    version: RoomVersion,
}

impl std::fmt::Debug for Measuring {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "motion {} is being measured", self.clip.id.0)
    }
}

impl EditorState {
    pub(in crate::app) fn keep_clip_report(
        &mut self,
        clip: &Arc<Clip>,
        version: RoomVersion,
        report: MotionReport,
    ) {
        let measured = MeasuredClip { clip: clip.clone(), version, report: Arc::new(report) };
        self.motion.measured.insert(clip.id, measured);
    }

    pub(in crate::app) fn poll_clip_measure(&mut self) {
        let Some(measuring) = &mut self.jobs.measuring_clip else { return };
        let Some(outcome) = measuring.job.poll() else { return };
        let Some(measuring) = self.jobs.measuring_clip.take() else { return };
        match self.taken(measuring.job.name(), outcome) {
            Some(report) => self.keep_clip_report(&measuring.clip, measuring.version, report),
            None => self.motion.unmeasurable = Some(self.document.revision()),
        }
    }

    /// Measures the next motion that has changed, unless it is being dragged or made.
    pub(in crate::app) fn keep_clips_measured(&mut self) {
        let failed = self.motion.unmeasurable == Some(self.document.revision());
        let busy = self.jobs.measuring_clip.is_some() || self.jobs.making.is_some();
        if busy || failed || self.document.in_gesture() {
            return;
        }
        let Some(geometry) = self.geometry().cloned() else { return };
        let clips = &self.document.scene().clips;
        let Some(clip) = clips
            .iter()
            .find(|c| !c.frames.is_empty() && !self.is_day(c) && self.clip_report(c).is_none())
            .cloned()
        else {
            return;
        };
        let (engine, of) = (self.engine.clone(), clip.clone());
        let work = move |cx: &JobCtx| engine.measure_clip(&geometry, &of, cx.ticker());
        let job = Job::spawn("Measure motion", Seed::root(0), self.waker(), work);
        self.jobs.measuring_clip = Some(Measuring { job, clip, version: self.document.room_version() });
    }

    /// What is beyond its limits in the motions, each with its motion; the worst first.
    pub fn clip_findings(&self) -> Vec<(Arc<Clip>, Finding)> {
        let limits = MotionLimits::default();
        let clips = self.document.scene().clips.iter();
        let reports = clips.filter_map(|clip| Some((clip, self.clip_report(clip)?)));
        let mut findings: Vec<(Arc<Clip>, Finding)> = reports
            .flat_map(|(clip, report)| {
                report.findings(clip.id.0, &limits).into_iter().map(move |finding| (clip.clone(), finding))
            })
            .collect();
        findings.sort_by(|a, b| b.1.severity().total_cmp(&a.1.severity()));
        findings
    }

    /// The worst of each kind in each motion; a walk that slides does so in a hundred frames.
    pub fn worst_clip_findings(&self) -> Vec<(Arc<Clip>, Finding)> {
        let mut seen = Vec::new();
        let mut findings = self.clip_findings();
        findings.retain(|(clip, finding)| {
            let new = !seen.contains(&(clip.id, finding.metric));
            seen.push((clip.id, finding.metric));
            new
        });
        findings
    }
}
