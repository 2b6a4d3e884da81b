//! Background jobs: progress, cancel, previews, panic capture and the seed tree.
//!
//! Standard library only; knows no domain and no other module. The same function runs in the window
//! (through [`Job::spawn`]) and on the command line (through [`JobCtx::headless`]) and gives the same
//! bytes for the same [`Seed`]. This is the only place that starts threads or catches panics.

mod seed;

pub use seed::{Rng, Seed};

use std::any::Any;
use std::ops::Deref;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// The user asked the job to stop. Neither an error nor a result: it travels up by `?`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cancelled;

/// Why a job's function returned without a result.
#[derive(Debug)]
pub enum Stop {
    /// The user cancelled.
    Cancelled,
    /// It failed; the text says what, where and what to do.
    Failed(String),
}

impl From<Cancelled> for Stop {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}

impl<E: std::error::Error> From<E> for Stop {
    fn from(error: E) -> Self {
        Self::Failed(error.to_string())
    }
}

/// How a job ended.
#[derive(Debug)]
pub enum Outcome<T> {
    /// The result.
    Done(T),
    /// Cancelled by the user; the last preview stays in the job.
    Cancelled,
    /// Failed with a message for the user.
    Failed(String),
    /// A bug: the panic's message. The document is untouched.
    Panicked(String),
}

/// Runs `work` and turns its return, or its panic, into an [`Outcome`]. The one panic boundary of the program.
pub fn run_caught<T>(work: impl FnOnce() -> Result<T, Stop>) -> Outcome<T> {
    #[expect(clippy::disallowed_methods, reason = "this is the boundary the lint points to")]
    match std::panic::catch_unwind(std::panic::AssertUnwindSafe(work)) {
        Ok(Ok(value)) => Outcome::Done(value),
        Ok(Err(Stop::Cancelled)) => Outcome::Cancelled,
        Ok(Err(Stop::Failed(message))) => Outcome::Failed(message),
        Err(payload) => Outcome::Panicked(panic_message(payload.as_ref())),
    }
}

fn panic_message(payload: &(dyn Any + Send)) -> String {
    payload
        .downcast_ref::<&str>()
        .map(|s| (*s).to_owned())
        .or_else(|| payload.downcast_ref::<String>().cloned())
        .unwrap_or_else(|| "panic without a message".to_owned())
}

/// How far a job is. `done` of `total` counts the units of the present stage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// What is being done, in words for the user.
    pub stage: &'static str,
    /// Units done in this stage.
    pub done: usize,
    /// Units of this stage; 0 while unknown.
    pub total: usize,
    /// Time since the stage began.
    pub elapsed: Duration,
}

impl Progress {
    /// Share done, 0 to 1.
    pub fn fraction(&self) -> f32 {
        if self.total == 0 { 0.0 } else { (self.done as f32 / self.total as f32).min(1.0) }
    }

    /// Time the stage still needs at its mean rate so far.
    pub fn remaining(&self) -> Option<Duration> {
        let left = self.total.checked_sub(self.done)?;
        (self.done > 0).then(|| self.elapsed.mul_f64(left as f64 / self.done as f64))
    }
}

struct Shared {
    cancel: AtomicBool,
    progress: Mutex<(&'static str, usize, usize, Instant)>,
    wake: Box<dyn Fn() + Send + Sync>,
}

/// Reports progress and learns of a cancel, in one call. Cheap to clone, shared by all threads of a job.
#[derive(Clone)]
pub struct Ticker {
    shared: Arc<Shared>,
    /// Whether stages and steps are shown; a cancel is noticed in any case.
    shown: bool,
}

impl Ticker {
    fn new(wake: Box<dyn Fn() + Send + Sync>) -> Self {
        let progress = Mutex::new(("starting", 0, 0, Instant::now()));
        Self { shared: Arc::new(Shared { cancel: AtomicBool::new(false), progress, wake }), shown: true }
    }

    /// A ticker that nobody watches, for tests and for library callers.
    pub fn silent() -> Self {
        Self::new(Box::new(|| ()))
    }

    /// The same job's ticker for a part of it that runs beside other parts: a cancel is noticed, progress is not
    /// shown.
    #[must_use]
    pub fn without_progress(&self) -> Self {
        Self { shared: self.shared.clone(), shown: false }
    }

    /// Begins a named stage of `total` units.
    ///
    /// # Errors
    /// [`Cancelled`] once the user cancelled.
    pub fn stage(&self, name: &'static str, total: usize) -> Result<(), Cancelled> {
        if self.shown {
            *lock(&self.shared.progress) = (name, 0, total, Instant::now());
            self.wake();
        }
        self.check()
    }

    /// Reports `done` of `total` units of the present stage. Call it at least every 50 ms.
    ///
    /// # Errors
    /// [`Cancelled`] once the user cancelled.
    pub fn step(&self, done: usize, total: usize) -> Result<(), Cancelled> {
        if self.shown {
            let mut progress = lock(&self.shared.progress);
            progress.1 = done;
            progress.2 = total;
            drop(progress);
            self.wake();
        }
        self.check()
    }

    /// Reports one more unit of the present stage; for units that finish in any order.
    ///
    /// # Errors
    /// [`Cancelled`] once the user cancelled.
    pub fn advance(&self) -> Result<(), Cancelled> {
        if self.shown {
            lock(&self.shared.progress).1 += 1;
            self.wake();
        }
        self.check()
    }

    /// Only asks whether to go on.
    ///
    /// # Errors
    /// [`Cancelled`] once the user cancelled.
    pub fn check(&self) -> Result<(), Cancelled> {
        if self.shared.cancel.load(Ordering::Relaxed) { Err(Cancelled) } else { Ok(()) }
    }

    /// How far the job is.
    pub fn progress(&self) -> Progress {
        let (stage, done, total, since) = *lock(&self.shared.progress);
        Progress { stage, done, total, elapsed: since.elapsed() }
    }

    /// Asks the job to stop at its next step.
    pub fn cancel(&self) {
        self.shared.cancel.store(true, Ordering::Relaxed);
    }

    fn wake(&self) {
        (self.shared.wake)();
    }
}

/// What a job's function gets: its seed, its [`Ticker`] (by deref) and a slot for previews of type `P`.
pub struct JobCtx<P = ()> {
    /// Root of this job's seed tree.
    pub seed: Seed,
    ticker: Ticker,
    show: Arc<dyn Fn(P) + Send + Sync>,
}

impl<P: 'static> JobCtx<P> {
    /// A context without a window: nobody reads the previews.
    pub fn headless(seed: Seed) -> Self {
        Self::watched(seed, Ticker::silent())
    }

    /// A headless context whose progress is shown through `ticker` and can be cancelled by it.
    pub fn watched(seed: Seed, ticker: Ticker) -> Self {
        Self { seed, ticker, show: Arc::new(|_| ()) }
    }

    /// A context for a part of this job whose previews are of another type: `map` turns them into this job's.
    pub fn mapped<Q: 'static>(&self, map: impl Fn(Q) -> P + Send + Sync + 'static) -> JobCtx<Q> {
        let show = self.show.clone();
        let show = Arc::new(move |value: Q| show(map(value)));
        JobCtx { seed: self.seed, ticker: self.ticker.clone(), show }
    }

    /// Overwrites the preview; the window shows the newest only, none are queued.
    pub fn preview(&self, value: P) {
        (self.show)(value);
        self.ticker.wake();
    }

    /// The progress and cancel handle, for functions that have no previews.
    pub fn ticker(&self) -> &Ticker {
        &self.ticker
    }
}

impl<P> Deref for JobCtx<P> {
    type Target = Ticker;
    fn deref(&self) -> &Ticker {
        &self.ticker
    }
}

/// A running or finished job with result `T` and previews `P`, owned by whoever waits for it.
/// Dropping it cancels it.
pub struct Job<T, P = ()> {
    name: String,
    ticker: Ticker,
    preview: Arc<Mutex<Option<P>>>,
    outcome: Arc<Mutex<Option<Outcome<T>>>>,
    started: Instant,
}

impl<T: Send + 'static, P: Send + 'static> Job<T, P> {
    /// Starts `work` on a thread of its own. `wake` is called after each step, preview and once more after
    /// the end (the trailing repaint), and must not block.
    pub fn spawn(
        name: impl Into<String>,
        seed: Seed,
        wake: impl Fn() + Send + Sync + 'static,
        work: impl FnOnce(&JobCtx<P>) -> Result<T, Stop> + Send + 'static,
    ) -> Self {
        let name = name.into();
        let ticker = Ticker::new(Box::new(wake));
        let preview = Arc::new(Mutex::new(None));
        let newest = preview.clone();
        let show = Arc::new(move |value: P| *lock(&newest) = Some(value));
        let cx = JobCtx { seed, ticker: ticker.clone(), show };
        let outcome = Arc::new(Mutex::new(None));
        let slot = outcome.clone();
        let run = move || {
            let ended = run_caught(|| work(&cx));
            *lock(&slot) = Some(ended);
            cx.wake();
        };
        #[expect(clippy::disallowed_methods, reason = "the one place that starts threads")]
        std::thread::spawn(run);
        Self { name, ticker, preview, outcome, started: Instant::now() }
    }

    /// The outcome, once; `None` while running and after it was taken.
    pub fn poll(&mut self) -> Option<Outcome<T>> {
        lock(&self.outcome).take()
    }

    /// The newest preview since the last call.
    pub fn take_preview(&self) -> Option<P> {
        lock(&self.preview).take()
    }

    /// The job's name for the job list.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// How far it is.
    pub fn progress(&self) -> Progress {
        self.ticker.progress()
    }

    /// Time since it was started.
    pub fn elapsed(&self) -> Duration {
        self.started.elapsed()
    }

    /// Asks it to stop at its next step.
    pub fn cancel(&self) {
        self.ticker.cancel();
    }
}

impl<T, P> Drop for Job<T, P> {
    fn drop(&mut self) {
        self.ticker.cancel();
    }
}

/// A panic while the lock was held leaves a whole value behind in every use here, so poison is ignored.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::AtomicUsize;

    fn wait<T: Send + 'static, P: Send + 'static>(job: &mut Job<T, P>) -> Outcome<T> {
        loop {
            if let Some(outcome) = job.poll() {
                return outcome;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    #[test]
    fn a_job_delivers_its_result_and_its_newest_preview() {
        let mut job = Job::<u32, u32>::spawn(
            "count",
            Seed::root(1),
            || (),
            |cx| {
                for i in 0..100 {
                    cx.step(i, 100)?;
                    cx.preview(i as u32);
                }
                Ok(7)
            },
        );
        assert!(matches!(wait(&mut job), Outcome::Done(7)));
        assert_eq!(job.take_preview(), Some(99));
        assert_eq!(job.take_preview(), None);
        assert_eq!(job.progress().done, 99);
    }

    #[test]
    fn a_part_of_a_job_shows_its_own_previews_as_those_of_the_job() {
        let work = |cx: &JobCtx<String>| {
            cx.mapped(|number: u32| format!("{number} done")).preview(3);
            Ok(())
        };
        let mut job = Job::spawn("parts", Seed::root(1), || (), work);
        assert!(matches!(wait(&mut job), Outcome::Done(())));
        assert_eq!(job.take_preview().as_deref(), Some("3 done"));
    }

    #[test]
    fn a_cancelled_job_stops_at_its_next_step() {
        let mut job = Job::<()>::spawn(
            "forever",
            Seed::root(1),
            || (),
            |cx| {
                loop {
                    cx.step(0, 0)?;
                }
            },
        );
        job.cancel();
        assert!(matches!(wait(&mut job), Outcome::Cancelled));
    }

    #[test]
    fn a_panic_stays_in_the_job_and_says_what_broke() {
        let mut job = Job::<()>::spawn("bug", Seed::root(1), || (), |_| panic!("index {} is out", 3));
        assert!(matches!(wait(&mut job), Outcome::Panicked(m) if m == "index 3 is out"));
    }

    #[test]
    fn the_window_is_woken_once_more_after_the_end() {
        let wakes = Arc::new(AtomicUsize::new(0));
        let seen = wakes.clone();
        let mut job = Job::<()>::spawn(
            "quick",
            Seed::root(1),
            move || {
                seen.fetch_add(1, Ordering::SeqCst);
            },
            |_| Ok(()),
        );
        wait(&mut job);
        std::thread::sleep(Duration::from_millis(20));
        assert_eq!(wakes.load(Ordering::SeqCst), 1);
    }

    #[test]
    fn remaining_time_is_extrapolated_from_the_rate() {
        let progress = Progress { stage: "", done: 25, total: 100, elapsed: Duration::from_secs(1) };
        assert_eq!(progress.remaining(), Some(Duration::from_secs(3)));
        assert_eq!(Progress { done: 0, ..progress }.remaining(), None);
    }
}
