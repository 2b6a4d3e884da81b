//! What a person's motion through a room costs from end to end: how soon ten seconds are ready and something plays,
//! how time and memory grow with the length, and how soon a cancelled job is back.
//!
//! `cargo bench --bench journey` does all three in the living room; `cargo bench --bench journey -- ready`, `grow` and
//! `cancel` one of them, `-- cancel ROOM` in a room's file. Lengths are measured in a process each, so that none finds
//! memory that another left.

use std::path::Path;
use std::process::Command;
use std::sync::Arc;
use std::thread::sleep;
use std::time::{Duration, Instant};

use inhabit::assets::{Budget, read_model, read_model_bytes, sample_rooms};
use inhabit::body::Body;
use inhabit::evolve::journey::{Journey, JourneyPreview, JourneyRequest, journey, tour};
use inhabit::job::{Job, JobCtx, Seed, Ticker};
use inhabit::scene::{
    GeometryConfig, ImportOptions, Room, RoomGeometry, SubGoal, SubGoalId, room_from_model,
};

/// Seconds of motion whose cost is compared.
const LENGTHS_S: [usize; 5] = [10, 30, 60, 120, 300];
/// A tour through all of the living room takes about so long; longer motions go on with another.
const ROUND_S: usize = 60;
/// Moments at which a job is cancelled.
const CANCELS: u32 = 40;

type Place = Arc<(Room, RoomGeometry)>;

fn main() {
    let given: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    let given: Vec<&str> = given.iter().map(String::as_str).collect();
    let is_bench = std::env::args().any(|argument| argument == "--bench");
    match given[..] {
        // As a test: one journey shows that it runs.
        [] if !is_bench => ready(&place("sample:living"), 1),
        [] => {
            ready(&place("sample:living"), 3);
            grow();
            cancel(&place("sample:living"));
        }
        ["ready"] => ready(&place("sample:living"), 3),
        ["grow"] => grow(),
        ["length", seconds] => length(seconds.parse().expect("seconds")),
        ["cancel"] => cancel(&place("sample:living")),
        ["cancel", room] => cancel(&place(room)),
        _ => eprintln!("ready, grow, cancel or cancel ROOM"),
    }
}

fn place(name: &str) -> Place {
    let known = sample_rooms().iter().find(|s| name.strip_prefix("sample:") == Some(s.key));
    let model = match known {
        Some(sample) => read_model_bytes(sample.key, sample.glb, &Budget::default()),
        None => read_model(Path::new(name), &Budget::default()),
    };
    let room = room_from_model(&model.expect("a room"), &ImportOptions::default()).room;
    let go_on = |_, _| std::ops::ControlFlow::Continue(());
    let geometry = RoomGeometry::build(&room, &GeometryConfig::default(), &go_on).expect("not stopped");
    Arc::new((room, geometry))
}

/// Tours after one another, about so long in all.
fn asked(place: &Place, seconds: usize) -> JourneyRequest {
    let (room, geometry) = &**place;
    let mut goals: Vec<SubGoal> = Vec::new();
    let mut left = seconds;
    while left > 0 {
        let part = left.min(ROUND_S);
        goals.extend(tour(room, geometry, part as f32, &Ticker::silent()).expect("not cancelled"));
        left -= part;
    }
    let numbered = goals.into_iter().zip(0..).map(|(goal, id)| SubGoal { id: SubGoalId(id), ..goal });
    JourneyRequest { goals: numbered.collect(), ..JourneyRequest::default() }
}

fn made(place: &Place, request: &JourneyRequest) -> Journey {
    let cx: JobCtx<JourneyPreview> = JobCtx::headless(Seed::root(0));
    journey(&place.0, &place.1, Body::bundled(), request, &cx).expect("a journey")
}

/// A clip of ten seconds, from the request to the measured motion, some times.
fn ready(place: &Place, runs: usize) {
    let mut request = asked(place, 10);
    // A whole tour takes longer: from the door to the first seat, and a while there.
    request.goals.truncate(2);
    request.goals.iter_mut().for_each(|goal| goal.stay_s = 0.0);
    let way_s = made(place, &request).clip.seconds();
    request.goals.iter_mut().skip(1).for_each(|goal| goal.stay_s = (10.0 - way_s).max(0.0));
    for run in 1..=runs {
        let started = Instant::now();
        let made = made(place, &request);
        let (all, s) = (started.elapsed().as_secs_f64(), &made.seconds);
        println!(
            "ready {run}: {:.1} s of motion in {all:.2} s; first preview after {:.2} s, bodies {:.2}, poses {:.2}, fit {:.2}, \
             measured {:.2}",
            made.clip.seconds(),
            s.first_preview,
            s.bodies,
            s.poses,
            s.fit,
            s.measure
        );
    }
}

fn grow() {
    let this = std::env::current_exe().expect("this program");
    println!(
        "{:>8} {:>10} {:>12} {:>14} {:>12} {:>14}",
        "seconds", "clock s", "processor s", "ms per second", "more MB", "MB per second"
    );
    for seconds in LENGTHS_S {
        let status = Command::new(&this).arg("length").arg(seconds.to_string()).status();
        assert!(status.is_ok_and(|s| s.success()), "{seconds} s");
    }
}

/// One length in this process: a row of the table.
fn length(seconds: usize) {
    let place = place("sample:living");
    // What is made once for a body and a room is no cost of length.
    made(
        &place,
        &JourneyRequest { goals: asked(&place, 10).goals[..2].to_vec(), ..JourneyRequest::default() },
    );
    let request = asked(&place, seconds);
    reset_peak();
    let (before_mb, before_s) = (kilobytes("VmRSS:") / 1e3, processor_s());
    let started = Instant::now();
    let made = made(&place, &request);
    let (clock_s, busy_s) = (started.elapsed().as_secs_f64(), processor_s() - before_s);
    let (length_s, more_mb) = (f64::from(made.clip.seconds()), kilobytes("VmHWM:") / 1e3 - before_mb);
    println!(
        "{length_s:>8.1} {clock_s:>10.2} {busy_s:>12.2} {:>14.1} {more_mb:>12.1} {:>14.2}",
        1e3 * busy_s / length_s,
        more_mb / length_s
    );
}

/// Lets the kernel count the most memory anew (Linux; elsewhere memory is told as 0).
fn reset_peak() {
    // Fails where the system keeps no such file; then nothing is told of memory either.
    std::fs::write("/proc/self/clear_refs", "5").ok();
}

fn kilobytes(name: &str) -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix(name));
    line.and_then(|rest| rest.trim().split(' ').next()?.parse().ok()).unwrap_or(0.0)
}

/// Processor seconds of this process, all threads; 0 where the system doesn't tell. A hundredth is the unit of Linux.
fn processor_s() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let after_name = stat.rsplit(')').next().unwrap_or_default();
    let ticks = |at: usize| after_name.split_whitespace().nth(at).and_then(|n| n.parse::<f64>().ok());
    (ticks(11).unwrap_or(0.0) + ticks(12).unwrap_or(0.0)) * 1e-2
}

/// Cancels a job at even steps of its time and waits for its end.
fn cancel(place: &Place) {
    let request = asked(place, ROUND_S);
    let started = Instant::now();
    made(place, &request);
    let whole = started.elapsed();
    let mut waits: Vec<Wait> = Vec::new();
    for number in 0..CANCELS {
        let at = whole * number / CANCELS;
        let (place, request) = (place.clone(), request.clone());
        let work =
            move |cx: &JobCtx<JourneyPreview>| journey(&place.0, &place.1, Body::bundled(), &request, cx);
        let mut job: Job<Journey, JourneyPreview> = Job::spawn("journey", Seed::root(0), || (), work);
        sleep(at);
        let stage = job.progress().stage;
        let (cancelled, before_s) = (Instant::now(), processor_s());
        job.cancel();
        while job.poll().is_none() {
            sleep(Duration::from_millis(1));
        }
        let clock_ms = cancelled.elapsed().as_secs_f64() * 1e3;
        waits.push(Wait { clock_ms, busy_ms: (processor_s() - before_s) * 1e3, at, stage });
    }
    waits.sort_by(|a, b| a.clock_ms.total_cmp(&b.clock_ms));
    println!(
        "cancelled at {CANCELS} moments of {:.1} s: back after {:.0} ms (median), {:.0} ms (longest); the processor worked \
         {:.0} ms at most",
        whole.as_secs_f64(),
        waits[waits.len() / 2].clock_ms,
        waits[waits.len() - 1].clock_ms,
        waits.iter().map(|w| w.busy_ms).fold(0.0, f64::max)
    );
    for Wait { clock_ms, busy_ms, at, stage } in waits.iter().rev().take(4) {
        println!(
            "  {clock_ms:.0} ms, {busy_ms:.0} of the processor, at {:.2} s, while {stage}",
            at.as_secs_f64()
        );
    }
}

/// From a cancel to the job's end: by the clock, and of the processor (all threads), which other programs don't lengthen.
struct Wait {
    clock_ms: f64,
    busy_ms: f64,
    at: Duration,
    stage: &'static str,
}
