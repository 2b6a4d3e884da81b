//! How motions are made, measured, looked at and written, as it really is: the part of the engine behind the motion
//! panel and the timeline. Runs in jobs but for what says so; may not touch the editor's state.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use glam::{Mat3, Quat, Vec2, Vec3};

use super::engine::{MotionExport, MotionFormat, MotionMethod, MovePreview, MoveTask, Moved};
use super::motion::renumbered;
use super::real::asks;
use crate::assets::GifWriter;
use crate::assets::encode_png;
use crate::assets::write_bvh;
use crate::body::Body;
use crate::body::FamilyHints;
use crate::body::Region;
use crate::body::amass_motion;
use crate::body::read_clips;
use crate::body::rig_motion;
use crate::body::sample_pose;
use crate::document::write_folder;
use crate::evolve::journey::{self, JourneyPreview, JourneyRequest, journey};
use crate::inspect::MotionReport;
use crate::inspect::inspect_motion;
use crate::job::{JobCtx, Seed, Stop, Ticker};
use crate::motion::plan::{PlanConfig, Planner, Spot};
use crate::motion::retrieval::MotionMemory;
use crate::render::Backend;
use crate::render::BodySurface;
use crate::render::Cutaway;
use crate::render::Film;
use crate::render::Painter;
use crate::render::PersonDraw;
use crate::render::Picture;
use crate::render::SceneDraw;
use crate::render::Shown;
use crate::render::clips_glb;
use crate::render::moving_room_glb;
use crate::scene::BETAS;
use crate::scene::Clip;
use crate::scene::Frame;
use crate::scene::GoalPose;
use crate::scene::Person;
use crate::scene::PoseFamily;
use crate::scene::Room;
use crate::scene::RoomGeometry;
use crate::scene::Scene;
use crate::scene::SubGoal;
use crate::scene::SubGoalId;
use crate::scene::direction_of;

/// Pictures in a second of a GIF: what pages and messengers play.
const GIF_FPS: f32 = 15.0;
/// Higher than this above the floor somebody sits or lies rather than stands, metres.
const SEAT_M: f32 = 0.15;
/// Surfaces at least so high and so low are seats to a place holder, lower ones the floor, metres.
const CHAIR_M: f32 = 0.3;
/// Where one may stand before a seat: so far from it, metres, all around.
const BEFORE_SEAT_M: [f32; 2] = [0.45, 0.7];
const WAYS_TO_A_SEAT: usize = 8;

/// The folder of clips that was remembered last: reading it again for every motion would take seconds.
#[derive(Default)]
pub struct Memories(Mutex<Option<(PathBuf, Arc<MotionMemory>)>>);

impl Memories {
    /// What is remembered of a folder.
    ///
    /// # Errors
    /// Without a folder, or why its clips can't be read; or cancelled.
    fn of(&self, folder: Option<&Path>, ticker: &Ticker) -> Result<Arc<MotionMemory>, Stop> {
        let folder = folder.ok_or_else(|| {
            Stop::Failed(
                "captured pieces need clips: choose a folder of them (npz, BVH) below the method".to_owned(),
            )
        })?;
        let lock = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let known = lock().as_ref().filter(|(of, _)| of == folder).map(|(_, memory)| memory.clone());
        if let Some(memory) = known {
            return Ok(memory);
        }
        ticker.stage("reading clips", 0)?;
        let memory = Arc::new(MotionMemory::new(&read_clips(folder)?, Body::bundled(), ticker)?);
        *lock() = Some((folder.to_path_buf(), memory.clone()));
        Ok(memory)
    }
}

/// Makes a motion.
///
/// # Errors
/// Why it can't be made; or cancelled.
pub fn synthesise(task: &MoveTask, memories: &Memories, cx: &JobCtx<MovePreview>) -> Result<Moved, Stop> {
    let inner = cx.mapped(|preview: JourneyPreview| MovePreview { clip: preview.clip });
    let memory = match task.method {
        MotionMethod::Retrieval => Some(memories.of(task.clips.as_deref(), cx.ticker())?),
        _ => None,
    };
    let request = JourneyRequest { memory, ..request(task) };
    let made = journey(&task.room, &task.geometry, Body::bundled(), &request, &inner)?;
    let remarks = made.complaints(&task.room);
    Ok(Moved { clip: made.clip, report: Some(made.motion), remarks })
}

/// What is asked of the journey. Bodies are drawn by the numbers of their sub-goals, so one that is to be another
/// gets another number.
fn request(task: &MoveTask) -> JourneyRequest {
    let clip = &task.clip;
    let still = task.people.iter().map(|person| Arc::new(standing_still(person)));
    JourneyRequest {
        id: clip.id,
        name: clip.name.clone(),
        palette: clip.palette,
        betas: clip.betas,
        goals: renumbered(clip, &task.anew),
        method: match task.method {
            MotionMethod::Gait => journey::MotionMethod::Gait,
            MotionMethod::Learned => journey::MotionMethod::Learned,
            MotionMethod::Retrieval => journey::MotionMethod::Retrieval,
            MotionMethod::RouteCvae => journey::MotionMethod::RouteCvae,
        },
        kept: (!clip.frames.is_empty()).then(|| Arc::new(clip.clone())),
        others: task.others.iter().cloned().chain(still).collect(),
        ..JourneyRequest::default()
    }
}

/// Somebody who is in the way all the time: a motion of one frame.
fn standing_still(person: &Person) -> Clip {
    let pose = Body::bundled().pose_space.decode(&person.body.pose);
    Clip {
        name: person.name.clone(),
        betas: person.body.betas,
        frames: vec![Frame::of(&person.body, &pose)],
        planted: vec![[true, true]],
        ..Clip::default()
    }
}

/// Measures every frame.
///
/// # Errors
/// Cancelled.
pub fn measure(geometry: &RoomGeometry, clip: &Clip, ticker: &Ticker) -> Result<MotionReport, Stop> {
    ticker.stage("measuring frames", clip.frames.len())?;
    inspect_motion(&geometry.field, Body::bundled(), clip, &asks(ticker)).map_err(|_| Stop::Cancelled)
}

/// Whether one gets to a sub-goal from the one before it that was asked for; called by the window itself.
///
/// # Errors
/// What is in the way.
pub fn reach(room: &Room, geometry: &RoomGeometry, clip: &Clip, goal: SubGoalId) -> Result<(), String> {
    let Some(index) = clip.goals.iter().position(|g| g.id == goal) else { return Ok(()) };
    let planner = Planner::new(geometry, PlanConfig::default());
    let before = clip.goals[..index].iter().rev().find(|goal| !goal.planned);
    let to = spots(&clip.goals[index]);
    let from = before.map_or_else(|| to.clone(), spots);
    let mut first = None;
    for (from, to) in from.iter().flat_map(|from| to.iter().map(move |to| (from, to))) {
        let from = if before.is_some() { from } else { to };
        match planner.way(from, to, &[]) {
            Ok(_) => return Ok(()),
            Err(blocked) => first = first.or(Some(blocked)),
        }
    }
    first.map_or(Ok(()), |blocked| Err(blocked.in_words(room)))
}

/// Where one may stand for a sub-goal: on it, or before it if it is a seat or a bed.
fn spots(goal: &SubGoal) -> Vec<Spot> {
    if is_on_floor(goal) {
        return vec![Spot::open(goal.at)];
    }
    let first = goal.facing.unwrap_or(0.0);
    let around = |i: usize| first + std::f32::consts::TAU * i as f32 / WAYS_TO_A_SEAT as f32;
    let places = BEFORE_SEAT_M.into_iter().flat_map(|far_m| {
        (0..WAYS_TO_A_SEAT).map(move |i| {
            let way = direction_of(around(i)) * far_m;
            Spot { at: Vec2::new(goal.at.x, goal.at.z) + way, heading: None, beside: true }
        })
    });
    places.collect()
}

fn is_on_floor(goal: &SubGoal) -> bool {
    match goal.pose {
        GoalPose::Walk | GoalPose::Stand => true,
        GoalPose::Sit | GoalPose::Lie => false,
        GoalPose::Any => goal.at.y < SEAT_M,
    }
}

/// Somebody at a sub-goal whose body is not made yet: the pose of its kind, set down on the point; not fitted.
pub fn stand_in(goal: &SubGoal, betas: &[f32; BETAS]) -> Frame {
    let body = Body::bundled();
    let (family, rests_on) = match goal.pose {
        GoalPose::Sit => (PoseFamily::SitChair, Some(Region::Butt)),
        GoalPose::Lie => (PoseFamily::LieUp, None),
        GoalPose::Any if goal.at.y >= CHAIR_M => (PoseFamily::SitChair, Some(Region::Butt)),
        _ => (PoseFamily::Stand, None),
    };
    let hints = FamilyHints { seat_height_m: rests_on.map(|_| goal.at.y), ..FamilyHints::default() };
    let mut rng = Seed::root(u64::from(goal.id.0)).child("stand in", 0).rng();
    let sampled = sample_pose(&body.model.joint_template, family, &mut rng, &hints);
    let turn = Mat3::from_rotation_y(goal.facing.unwrap_or(0.0));
    let params = sampled.params(body, *betas, &turn);
    let mut frame = Frame {
        rotation: Quat::from_mat3(&(turn * sampled.upright_from_body)).normalize(),
        pose: sampled.pose,
        hands: params.hands,
        translation: Vec3::ZERO,
    };
    let posed = body.pose_frame(betas, &frame);
    let lowest = |vertices: &mut dyn Iterator<Item = usize>| {
        vertices.map(|v| posed.vertices[v].y).fold(f32::INFINITY, f32::min)
    };
    let under_m = match rests_on {
        Some(region) => lowest(&mut body.regions.vertices(region).iter().map(|v| *v as usize)),
        None => lowest(&mut (0..posed.vertices.len())),
    };
    let pelvis = posed.joints[0];
    frame.translation = goal.at - Vec3::new(pelvis.x, under_m, pelvis.z);
    frame
}

/// Writes motions; how many files.
///
/// # Errors
/// What, which file, what to do; or cancelled.
pub fn export(
    path: &Path,
    export: &MotionExport,
    surface: &Arc<BodySurface>,
    ticker: &Ticker,
) -> Result<usize, Stop> {
    ticker.stage("writing", export.clips.len())?;
    let clips = || export.clips.iter().map(Arc::as_ref);
    let name = match export.clips.as_slice() {
        [only] => &only.name,
        _ => &export.scene.room.name,
    };
    let files: Vec<(PathBuf, Vec<u8>)> = match export.format {
        MotionFormat::Glb => vec![(path.to_path_buf(), clips_glb(name, None, clips(), surface)?)],
        MotionFormat::GlbWithRoom => {
            let room = &export.scene.room;
            let things: Vec<_> = export.changes.tracks.iter().filter_map(|t| t.motion_in(room)).collect();
            vec![(path.to_path_buf(), moving_room_glb(name, Some(room), &things, clips(), surface)?)]
        }
        MotionFormat::Bvh => {
            numbered(path, export, |clip| Ok(write_bvh(&rig_motion(Body::bundled(), clip)).into_bytes()))?
        }
        MotionFormat::Amass => {
            numbered(path, export, |clip| Ok(amass_motion(Body::bundled(), clip).to_npz()?))?
        }
        MotionFormat::Gif => vec![(path.to_path_buf(), gif(export, surface, ticker)?)],
        MotionFormat::Pictures => return pictures(path, export, surface, ticker),
    };
    for (file, bytes) in &files {
        write(file, bytes)?;
    }
    Ok(files.len())
}

/// One file for each motion; from the second on its number stands in the name.
fn numbered(
    path: &Path,
    export: &MotionExport,
    bytes: impl Fn(&Clip) -> Result<Vec<u8>, Stop>,
) -> Result<Vec<(PathBuf, Vec<u8>)>, Stop> {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let ending = path.extension().map_or(export.format.ending().into(), |e| e.to_string_lossy().into_owned());
    let file = |i: usize| match i {
        0 => path.to_path_buf(),
        _ => path.with_file_name(format!("{stem}-{}.{ending}", i + 1)),
    };
    export.clips.iter().enumerate().map(|(i, clip)| Ok((file(i), bytes(clip)?))).collect()
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), Stop> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    Ok(write_folder(folder, &[(name, bytes.to_vec())])?)
}

/// What the view shows, without anything of the editor in it: a film of each state of the room.
struct Show {
    /// From when on, seconds.
    films: Vec<(f32, Film)>,
}

impl Show {
    fn new(export: &MotionExport, surface: &Arc<BodySurface>, fps: f32) -> Self {
        let still = || vec![(0.0, export.scene.room.clone())];
        let rooms = if export.changes.rooms.is_empty() { still() } else { export.changes.rooms.clone() };
        let film = |(from_s, room)| (from_s, film(export, room, surface, fps));
        Self { films: rooms.into_iter().map(film).collect() }
    }

    fn pictures(&self) -> usize {
        self.films.first().map_or(0, |(_, film)| film.pictures())
    }

    fn draw(&self, painter: &Painter, number: usize) -> Result<Picture, Stop> {
        let begun = |(from_s, film): &&(f32, Film)| *from_s <= number as f32 / film.fps;
        let film = self.films.iter().rev().find(begun).or(self.films.first());
        let (_, film) = film.ok_or_else(|| Stop::Failed("there is nothing to draw".to_owned()))?;
        Ok(film.draw(painter, number)?)
    }
}

fn film(export: &MotionExport, room: Arc<Room>, surface: &Arc<BodySurface>, fps: f32) -> Film {
    let mut scene = SceneDraw::of_room(&Scene { room, ..export.scene.clone() });
    scene.body = Some(surface.clone());
    scene.look.cutaway = Cutaway::Outside;
    scene.look.grid = Shown::No;
    let stays =
        export.scene.people.iter().filter(|p| p.visible && !super::motion::moves(&export.clips, p.id));
    scene.people = stays
        .map(|p| PersonDraw::new(p.id, Body::bundled().pose(&p.body).vertices.into(), p.palette))
        .collect();
    Film { scene, clips: export.clips.clone(), camera: export.camera, size: export.size, fps }
}

fn gif(export: &MotionExport, surface: &Arc<BodySurface>, ticker: &Ticker) -> Result<Vec<u8>, Stop> {
    let show = Show::new(export, surface, GIF_FPS);
    let painter = Painter::new(Backend::Auto)?;
    let mut writer = GifWriter::new(export.size[0], export.size[1], GIF_FPS)?;
    ticker.stage("drawing", show.pictures())?;
    for number in 0..show.pictures() {
        writer.add(&show.draw(&painter, number)?.rgba)?;
        ticker.advance()?;
    }
    Ok(writer.finish())
}

/// `0001.png` and so on in a folder.
fn pictures(
    folder: &Path,
    export: &MotionExport,
    surface: &Arc<BodySurface>,
    ticker: &Ticker,
) -> Result<usize, Stop> {
    let fps = export.clips.first().map_or(crate::scene::CLIP_FPS, |clip| clip.fps);
    let show = Show::new(export, surface, fps);
    let painter = Painter::new(Backend::Auto)?;
    ticker.stage("drawing", show.pictures())?;
    for number in 0..show.pictures() {
        let picture = show.draw(&painter, number)?;
        let png = encode_png(picture.width, picture.height, &picture.rgba)?;
        write_folder(folder, &[(format!("{:04}.png", number + 1), png)])?;
        ticker.advance()?;
    }
    Ok(show.pictures())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::engine::RoomChanges;

    fn goal(pose: GoalPose, height_m: f32) -> SubGoal {
        SubGoal {
            id: SubGoalId(3),
            at: Vec3::new(1.0, height_m, -2.0),
            facing: Some(0.7),
            pose,
            stay_s: 0.0,
            planned: false,
            locked: false,
            body: None,
        }
    }

    #[test]
    fn a_place_holder_is_on_its_spot_and_faces_where_it_is_told() {
        let betas = [0.0; BETAS];
        let body = Body::bundled();
        for (pose, height_m) in [(GoalPose::Stand, 0.0), (GoalPose::Sit, 0.45), (GoalPose::Any, 0.5)] {
            let frame = stand_in(&goal(pose, height_m), &betas);
            let posed = body.pose_frame(&betas, &frame);
            let pelvis = posed.joints[0];
            assert!(Vec2::new(pelvis.x - 1.0, pelvis.z + 2.0).length() < 1e-3, "{pose:?} at {pelvis}");
            let front = frame.rotation * Vec3::Z;
            let facing = crate::scene::facing_of(Vec2::new(front.x, front.z));
            assert!((facing - 0.7).abs() < 0.5, "{pose:?} faces {facing}");
            let lowest = posed.vertices.iter().map(|v| v.y).fold(f32::INFINITY, f32::min);
            assert!(lowest > -0.25 && pelvis.y > height_m, "{pose:?}: {lowest}, pelvis {pelvis}");
        }
    }

    fn short_walk(id: u32) -> Arc<Clip> {
        let frame =
            |i: usize| Frame { translation: Vec3::new(0.05 * i as f32, 0.9, 0.0), ..Frame::default() };
        let frames: Vec<Frame> = (0..7).map(frame).collect();
        let (id, name) = (crate::scene::ClipId(id), format!("Walk {id}"));
        Arc::new(Clip { id, name, planted: vec![[true, false]; 7], frames, ..Clip::default() })
    }

    #[test]
    fn models_skeletons_and_archives_are_opened_again_by_their_readers() {
        let folder = tempfile::tempdir().unwrap();
        let surface = Arc::new(BodySurface::of(Body::bundled()));
        let clips = vec![short_walk(0), short_walk(1)];
        let write = |format: MotionFormat, name: &str| {
            let (scene, camera) = (crate::scene::Scene::default(), crate::scene::Camera::default());
            let (clips, changes) = (clips.clone(), RoomChanges::default());
            let task = MotionExport { format, scene, clips, changes, camera, size: [48, 36] };
            let files = export(&folder.path().join(name), &task, &surface, &Ticker::silent());
            files.unwrap_or_else(|stop| panic!("{format:?}: {stop:?}"))
        };
        let path = |name: &str| folder.path().join(name);
        assert_eq!(write(MotionFormat::Glb, "walk.glb"), 1);
        let budget = crate::assets::Budget::default();
        assert!(crate::assets::read_model(&path("walk.glb"), &budget).is_ok());
        assert_eq!(write(MotionFormat::Bvh, "walk.bvh"), 2);
        assert!(path("walk.bvh").is_file() && path("walk-2.bvh").is_file());
        assert_eq!(write(MotionFormat::Amass, "walk.npz"), 2);
        let npz = crate::assets::npz::Npz::open(&path("walk-2.npz")).unwrap();
        assert_eq!(npz.floats("poses", &[None, None]).unwrap().0, [7, 156]);
    }
}
