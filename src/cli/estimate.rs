//! `inhabit estimate`: the person of a photo, in the room where it was taken.

use std::path::PathBuf;
use std::sync::Arc;

use anyhow::Context as _;
use clap::{Args, ValueEnum};
use glam::{Vec2, Vec3};

use super::generate::parse_point;
use super::load;
use super::output::OutputFolder;
use super::progress::run_job;
use super::report::BodyRow;
use super::scene_prior::{PriorSource, ScenePrior};
use super::{Common, Ended, use_threads};
use crate::assets::{self, Budget, PersonKeypoints, PictureKeypoints, read_keypoints, read_photo};
use crate::body::{Body, Workspace};
use crate::document::{Project, save_project};
use crate::evolve::{EstimateRequest, EstimatedPerson, EstimatorKind, estimate_person};
use crate::fit::estimation::Landmarks;
use crate::generate::sensor::{Sensor, View};
use crate::inspect::{Finding, Limits};
use crate::job::{JobCtx, Seed};
use crate::render::{Backend, BodySurface, Painter, PersonDraw, Picture, SceneDraw, person_glb};
use crate::scene::{Camera, POSE, Person, PersonId, Scene};

/// Arguments of `estimate`.
#[derive(Args, Debug)]
pub struct EstimateArguments {
    /// Keypoints: COCO json or OpenPose's BODY_25 json.
    #[arg(value_name = "KEYPOINTS")]
    pub keypoints: PathBuf,
    /// The room: a file, a project or `sample:NAME`.
    #[arg(long, value_name = "ROOM")]
    pub room: PathBuf,
    /// Where the camera stood: metres, world frame.
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_point, allow_hyphen_values = true)]
    pub eye: Vec3,
    /// A point in the middle of the picture: metres, world frame.
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_point, allow_hyphen_values = true)]
    pub target: Vec3,
    /// Vertical field of view of the camera, degrees.
    #[arg(long, default_value_t = 50.0, value_name = "DEG")]
    pub fov: f32,
    /// The photo (PNG or JPEG): tells the size and is drawn under the result.
    #[arg(long, value_name = "FILE")]
    pub photo: Option<PathBuf>,
    /// Size of the photo in pixels, where neither the photo nor the keypoint file tells it.
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub size: Option<[u32; 2]>,
    /// Which picture of the keypoint file, by its name there.
    #[arg(long, value_name = "NAME")]
    pub picture: Option<String>,
    /// Which person of the picture, 0 is the first; the one with the most keypoints when left out.
    #[arg(long, value_name = "N")]
    pub person: Option<usize>,
    /// Which estimator.
    #[arg(long, value_enum, default_value_t = Kind::Ours)]
    pub estimator: Kind,
    /// Who says what people do in the scene, for `--estimator ours`.
    #[arg(long, value_enum, default_value_t = PriorSource::S1)]
    pub prior: PriorSource,
    /// Weights of `inhabit train psi --method s1` instead of those that come with the program.
    #[arg(long, value_name = "FILE")]
    pub weights: Option<PathBuf>,
    /// Folder for the project, the person, the report and the pictures; must be new or empty.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Options of every command.
    #[command(flatten)]
    pub common: Common,
}

/// Estimators as the command line names them.
#[derive(ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Keypoints and priors: knows no room.
    SmplifyX,
    /// With the room's contact and collision.
    Prox,
    /// With the room, and the prior centred at what people do in this scene.
    Ours,
}

impl Kind {
    fn estimator(self) -> EstimatorKind {
        match self {
            Self::SmplifyX => EstimatorKind::SmplifyX,
            Self::Prox => EstimatorKind::Prox,
            Self::Ours => EstimatorKind::SceneAware,
        }
    }
}

fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let sides: Vec<u32> = text.split(['x', 'X']).filter_map(|n| n.trim().parse().ok()).collect();
    match sides.as_slice() {
        [width, height] if *width > 0 && *height > 0 => Ok([*width, *height]),
        _ => Err(format!("`{text}` is no size: write columns and rows in pixels as 1920x1080")),
    }
}

/// What is written as JSON.
#[derive(serde::Serialize)]
struct Report {
    command: &'static str,
    version: &'static str,
    seed: u64,
    estimator: &'static str,
    body: BodyRow,
    reprojection_px: f32,
    findings: Vec<Finding>,
}

/// The photo as far as it is known.
struct Photo {
    size: [u32; 2],
    pixels: Option<Picture>,
    person: PersonKeypoints,
}

/// Runs the command.
///
/// # Errors
/// When a file can't be read or written, or too few keypoints are there.
pub fn run(arguments: &EstimateArguments) -> anyhow::Result<Ended> {
    use_threads(arguments.common.threads)?;
    let photo = read(arguments)?;
    let loaded = load::load(Some(&arguments.room), &crate::scene::ImportOptions::default())?;
    let camera = Camera {
        eye: arguments.eye,
        target: arguments.target,
        fov_y: arguments.fov.clamp(1.0, 170.0).to_radians(),
        ortho_height_m: None,
    };
    let view = View::from_camera(&camera, photo.size[0], photo.size[1]);
    let folder = OutputFolder::claim(&arguments.out, false)?;
    let Some(found) = estimate(arguments, &loaded.room, view, &photo.person)? else {
        return Ok(Ended::Interrupted);
    };
    let mut people = loaded.people.clone();
    let person = person(&found, people.iter().map(|p| p.id.0 + 1).max().unwrap_or(0), arguments);
    people.push(person.clone());
    let scene = Scene { room: loaded.room.clone(), people, clips: Vec::new() };
    save_project(&folder.root().join("project.ron"), &Project::of_scene(scene.clone()))?;
    let file = format!("people/{:03}.glb", person.id.0);
    folder.write(&file, &person_glb(&person, &BodySurface::of(Body::bundled()))?)?;
    pictures(&folder, &scene, &camera, &view, &photo, &person)?;
    let report = Report {
        command: "estimate",
        version: env!("CARGO_PKG_VERSION"),
        seed: arguments.common.seed,
        estimator: arguments.estimator.estimator().label(),
        body: BodyRow::new(&person, &found.report.metrics, 0.0, file),
        reprojection_px: found.reprojection_px,
        findings: found.findings.clone(),
    };
    let json = serde_json::to_string_pretty(&report)?;
    folder.write("report.json", json.as_bytes())?;
    tell(arguments, &report, &json);
    Ok(if report.findings.is_empty() { Ended::Clean } else { Ended::WithFindings })
}

fn read(arguments: &EstimateArguments) -> anyhow::Result<Photo> {
    let pictures = read_keypoints(&arguments.keypoints, &Budget::default())?;
    let picture = choose_picture(&pictures, arguments.picture.as_deref())?;
    let person = choose_person(picture, arguments.person)?;
    let photo = arguments.photo.as_ref().map(|path| read_photo(path, &Budget::default())).transpose()?;
    let told = arguments.size.or(picture.size.map(|(width, height)| [width, height]));
    let size = photo.as_ref().map(|(_, size)| *size).or(told).context(
        "the photo's size is unknown: give the photo with --photo or its size with --size 1920x1080",
    )?;
    let pixels = photo.map(|(texture, _)| Picture {
        width: texture.width,
        height: texture.height,
        rgba: texture.rgba,
        backend: String::new(),
    });
    Ok(Photo { size, pixels, person })
}

fn choose_picture<'a>(
    pictures: &'a [PictureKeypoints],
    name: Option<&str>,
) -> anyhow::Result<&'a PictureKeypoints> {
    let names = || {
        let known: Vec<&str> = pictures.iter().filter_map(|p| p.name.as_deref()).take(8).collect();
        known.join(", ")
    };
    match (name, pictures) {
        (None, [only]) => Ok(only),
        (None, []) => anyhow::bail!("nobody is in the keypoint file: detect people with a lower threshold"),
        (None, many) => anyhow::bail!(
            "the keypoint file has {} pictures with people: choose one with --picture ({} …)",
            many.len(),
            names()
        ),
        (Some(name), _) => pictures.iter().find(|p| p.name.as_deref() == Some(name)).with_context(|| {
            format!("no picture with people is called {name} in the keypoint file; there are {} …", names())
        }),
    }
}

fn choose_person(picture: &PictureKeypoints, number: Option<usize>) -> anyhow::Result<PersonKeypoints> {
    let people = &picture.people;
    let chosen = match number {
        Some(number) => people.get(number),
        None => people.iter().max_by(|a, b| a.known().total_cmp(&b.known())),
    };
    chosen.cloned().with_context(|| {
        format!(
            "the picture has {} people: choose one with --person 0 to {}",
            people.len(),
            people.len().max(1) - 1
        )
    })
}

fn estimate(
    arguments: &EstimateArguments,
    room: &Arc<crate::scene::Room>,
    view: View,
    seen: &PersonKeypoints,
) -> anyhow::Result<Option<EstimatedPerson>> {
    let estimator = arguments.estimator.estimator();
    let prior = match estimator {
        EstimatorKind::SceneAware => Some(ScenePrior::of(arguments.prior, arguments.weights.as_deref())?),
        _ => None,
    };
    let (room, keypoints) = (room.clone(), seen.clone());
    let work = move |cx: &JobCtx| {
        let geometry = load::geometry(&room, cx.ticker())?;
        let mut scene_code = [0.0; POSE];
        if let Some(prior) = &prior {
            cx.stage("asking the scene", 0)?;
            let sensor = Sensor::new(&room, &geometry);
            let prior = prior.in_room(&room, &sensor, cx.seed.child("scene prior", 0), cx.ticker())?;
            scene_code = prior.code(&sensor.scene_image(&view), 0);
        }
        let request = EstimateRequest { view, keypoints, estimator, scene_code, limits: Limits::default() };
        estimate_person(&geometry, &request, &JobCtx::watched(cx.seed, cx.ticker().clone()))
    };
    run_job("estimate", Seed::root(arguments.common.seed), arguments.common.quiet, work)
}

fn person(found: &EstimatedPerson, id: u32, arguments: &EstimateArguments) -> Person {
    Person {
        id: PersonId(id),
        name: format!("Person {}", id + 1),
        body: found.params.clone(),
        family: found.family,
        on: "photo".to_owned(),
        seed: arguments.common.seed,
        palette: id,
        visible: true,
        locked: false,
    }
}

/// `from_camera.png`: the person in the room as the photo's camera sees them; `overlay.png`: the photo (or the empty
/// room) with the keypoints in green and the body's landmarks in orange.
fn pictures(
    folder: &OutputFolder,
    scene: &Scene,
    camera: &Camera,
    view: &View,
    photo: &Photo,
    person: &Person,
) -> anyhow::Result<()> {
    let body = Body::bundled();
    let size = fitting(photo.size);
    let painter = Painter::new(Backend::Auto)?;
    let mut draw = SceneDraw::of_room(scene);
    let empty = painter.picture(&draw, camera, size)?;
    draw.body = Some(Arc::new(BodySurface::of(body)));
    draw.people = vec![PersonDraw::new(person.id, body.pose(&person.body).vertices.into(), person.palette)];
    save(folder, "from_camera", &painter.picture(&draw, camera, size)?)?;
    let mut overlay = photo.pixels.clone().unwrap_or(empty);
    let scale = Vec2::new(overlay.width as f32, overlay.height as f32)
        / Vec2::new(photo.size[0] as f32, photo.size[1] as f32);
    let landmarks = Landmarks::of(&body.model);
    let mut workspace = Workspace::default();
    body.forward(&person.body, &landmarks.subset, &mut workspace);
    let positions = Landmarks::positions(photo.person.set, &workspace);
    for (position, point) in positions.iter().zip(&photo.person.points) {
        if point.confidence > 0.0 {
            dot(&mut overlay, point.pixel * scale, [60, 220, 90]);
        }
        if let Some((pixel, _)) = view.project(*position) {
            dot(&mut overlay, pixel * scale, [255, 150, 40]);
        }
    }
    save(folder, "overlay", &overlay)
}

/// The photo's shape, at most 1600 pixels long.
fn fitting([width, height]: [u32; 2]) -> [u32; 2] {
    let scale = (1600.0 / width.max(height) as f32).min(1.0);
    [width, height].map(|side| ((side as f32 * scale).round() as u32).max(1))
}

/// A disc with a dark rim around a pixel.
fn dot(picture: &mut Picture, at: Vec2, color: [u8; 3]) {
    let radius = 0.004 * picture.width.max(picture.height) as f32 + 1.0;
    let (low, high) = (at - radius - 1.0, at + radius + 1.0);
    let inside = |from: f32, to: f32, side: u32| {
        (from.max(0.0) as u32)..((to.max(0.0) as u32).saturating_add(1).min(side))
    };
    for y in inside(low.y, high.y, picture.height) {
        for x in inside(low.x, high.x, picture.width) {
            let away = Vec2::new(x as f32 + 0.5, y as f32 + 0.5).distance(at);
            let index = (y as usize * picture.width as usize + x as usize) * 4;
            if away <= radius + 1.0 {
                let shade = if away <= radius - 0.5 { color } else { [20, 20, 20] };
                picture.rgba[index..index + 3].copy_from_slice(&shade);
            }
        }
    }
}

fn save(folder: &OutputFolder, name: &str, picture: &Picture) -> anyhow::Result<()> {
    let png = assets::encode_png(picture.width, picture.height, &picture.rgba)?;
    folder.write(&format!("pictures/{name}.png"), &png)?;
    Ok(())
}

fn tell(arguments: &EstimateArguments, report: &Report, json: &str) {
    if arguments.common.json {
        println!("{json}");
    } else if !arguments.common.quiet {
        let m = &report.body.metrics;
        println!(
            "{} ({}): keypoints missed by {:.1} px, non-collision {:.3}, deepest penetration {:.0} mm, {}",
            report.body.pose,
            report.estimator,
            report.reprojection_px,
            m.psi_non_collision,
            m.penetration_max_mm,
            if m.supported { "held" } else { "not held by anything" }
        );
    }
}
