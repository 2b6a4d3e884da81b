//! Runs a job as the window does, with a progress bar instead of panels.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Once};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

use crate::job::{Job, JobCtx, Outcome, Seed, Stop};

/// How often the bar is redrawn and an interrupt is noticed.
const POLL: Duration = Duration::from_millis(30);

/// Runs `work` to its end. Ctrl-C cancels it at its next step and gives `Ok(None)`.
///
/// # Errors
/// The job's failure or panic, as a message for the user.
pub fn run_job<T: Send + 'static>(
    name: &str,
    seed: Seed,
    quiet: bool,
    work: impl FnOnce(&JobCtx) -> Result<T, Stop> + Send + 'static,
) -> anyhow::Result<Option<T>> {
    let interrupted = interrupt_flag();
    let bar = if quiet { ProgressBar::hidden() } else { ProgressBar::new(0) };
    bar.set_style(ProgressStyle::with_template("{msg:<28} {wide_bar} {pos}/{len} {elapsed}, {eta} left")?);
    let mut job = Job::<T>::spawn(name, seed, || (), work);
    loop {
        if let Some(outcome) = job.poll() {
            bar.finish_and_clear();
            return match outcome {
                Outcome::Done(value) => Ok(Some(value)),
                Outcome::Cancelled => Ok(None),
                Outcome::Failed(message) => Err(anyhow::anyhow!(message)),
                Outcome::Panicked(message) => Err(anyhow::anyhow!(
                    "a bug stopped `{name}`: {message}. Nothing was written; please report it with the command line"
                )),
            };
        }
        if interrupted.load(Ordering::Relaxed) {
            job.cancel();
        }
        let progress = job.progress();
        bar.set_message(progress.stage);
        bar.set_length(progress.total as u64);
        bar.set_position(progress.done as u64);
        std::thread::sleep(POLL);
    }
}

/// Set once the user pressed Ctrl-C.
fn interrupt_flag() -> Arc<AtomicBool> {
    static ONCE: Once = Once::new();
    static FLAG: std::sync::OnceLock<Arc<AtomicBool>> = std::sync::OnceLock::new();
    let flag = FLAG.get_or_init(Arc::default).clone();
    ONCE.call_once(|| {
        let flag = flag.clone();
        if let Err(error) = ctrlc::set_handler(move || flag.store(true, Ordering::Relaxed)) {
            eprintln!("Ctrl-C will end the program at once, without cancelling first: {error}");
        }
    });
    flag
}
