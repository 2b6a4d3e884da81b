//! Threads that frames alone use. The common pool's workers are busy with a job for seconds at a time, and a frame
//! that asked them would wait until they are done.

use std::sync::OnceLock;

use rayon::ThreadPool;

/// Enough for eight bodies or a texture within a frame; more would only take time from the jobs.
const THREADS: usize = 2;

/// Runs `work`, and what it does in parallel, on the frames' own threads.
pub fn for_frame<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    static POOL: OnceLock<Option<ThreadPool>> = OnceLock::new();
    let pool = POOL.get_or_init(|| {
        let named = |i| format!("frame worker {i}");
        rayon::ThreadPoolBuilder::new().num_threads(THREADS).thread_name(named).build().ok()
    });
    match pool {
        Some(pool) => pool.install(work),
        // A machine without threads to spare: this thread does it.
        None => work(),
    }
}

#[cfg(test)]
mod tests {
    use std::sync::{Arc, Barrier};

    use crossbeam_channel::bounded;
    use rayon::prelude::*;

    use super::for_frame;

    #[test]
    fn a_frame_is_made_while_every_thread_of_the_jobs_is_busy() {
        let workers = rayon::current_num_threads();
        let busy = Arc::new(Barrier::new(workers + 1));
        let releases: Vec<_> = (0..workers)
            .map(|_| {
                let (release, released) = bounded::<()>(1);
                let busy = Arc::clone(&busy);
                rayon::spawn(move || {
                    busy.wait();
                    let _ = released.recv();
                });
                release
            })
            .collect();
        busy.wait();
        let made: u64 = for_frame(|| (0..1000_u64).into_par_iter().sum());
        drop(releases);
        assert_eq!(made, 499_500);
    }
}
