//! A project as values of its text: what `project.ron` says, to the last bit of every number.
//!
//! The meshes stand in a GLB beside it (or in the same `.inhabit` archive), written by this program, one
//! part after the other; names, categories and transforms stand here, so that nothing is rounded on the way.

use std::sync::Arc;

use glam::{Affine3A, Mat3A, Vec3A};
use serde::{Deserialize, Serialize};

use super::change::NextIds;
use super::clips::{self, MotionsText};
use super::files::ProjectError;
use crate::assets::GlbWriteError;
use crate::assets::Model;
use crate::assets::content_hash;
use crate::assets::glb_from_model;
use crate::scene::Category;
use crate::scene::Object;
use crate::scene::ObjectId;
use crate::scene::ObjectPart;
use crate::scene::Person;
use crate::scene::Room;
use crate::scene::Scene;
use crate::scene::model_from_room;

/// What stands at the head of every project file.
const FORMAT: &str = "inhabit project";
/// Raised whenever an older program could no longer read what is written.
const VERSION: u32 = 2;
/// What projects without motions have: every program can read them.
const WITHOUT_MOTIONS: u32 = 1;

/// A scene and the numbers that its ids are taken from.
#[derive(Clone, Debug, Default)]
pub struct Project {
    /// Room, people and motions.
    pub scene: Scene,
    /// The numbers that the next ones get.
    pub next: NextIds,
}

impl Project {
    /// A project of a scene that no document ever changed: the next ids follow the largest ones in it.
    pub fn of_scene(scene: Scene) -> Self {
        let next = NextIds::after(&scene);
        Self { scene, next }
    }
}

/// The text of a project.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct ProjectText {
    format: String,
    version: u32,
    program: String,
    pub room: RoomText,
    objects: Vec<ObjectText>,
    people: Vec<Person>,
    /// Missing in projects of programs that knew no motions.
    #[serde(default)]
    pub motions: Option<MotionsText>,
    next_person: u32,
    next_object: u32,
    #[serde(default)]
    next_clip: u32,
}

/// Where the meshes are.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct RoomText {
    name: String,
    /// Beside the text; never a path.
    pub file: String,
    pub content_hash: String,
}

#[derive(Debug, Serialize, Deserialize)]
struct ObjectText {
    id: ObjectId,
    name: String,
    category: Category,
    visible: bool,
    locked: bool,
    world_from_object: [f32; 12],
    /// One transform for each mesh, in the order of the GLB.
    object_from_mesh: Vec<[f32; 12]>,
}

/// What a project is made of on disk.
pub(super) struct Written {
    pub text: String,
    pub glb: Vec<u8>,
    /// The motions' frames, if there are motions.
    pub motions: Option<Vec<u8>>,
}

/// Turns a project into text, meshes and frames; the text names their files as given.
pub(super) fn write(project: &Project, room_file: &str, motions_file: &str) -> Result<Written, WriteProblem> {
    let room = in_glb_order(&project.scene.room);
    let glb = glb_from_model(&model_from_room(&room))?;
    let has_motions = !project.scene.clips.is_empty();
    let motions = has_motions.then(|| clips::write(&project.scene.clips)).transpose()?;
    let text = ProjectText {
        format: FORMAT.to_owned(),
        version: if has_motions { VERSION } else { WITHOUT_MOTIONS },
        program: env!("CARGO_PKG_VERSION").to_owned(),
        room: RoomText { name: room.name.clone(), file: room_file.to_owned(), content_hash: hash_text(&glb) },
        objects: room.objects.iter().map(object_text).collect(),
        people: project.scene.people.clone(),
        motions: has_motions.then(|| MotionsText::of(&project.scene.clips, motions_file)),
        next_person: project.next.person,
        next_object: project.next.object,
        next_clip: project.next.clip,
    };
    let pretty = ron::ser::PrettyConfig::new().compact_arrays(true);
    Ok(Written { text: ron::ser::to_string_pretty(&text, pretty)?, glb, motions })
}

/// Why a project could not be turned into bytes.
#[derive(Debug, thiserror::Error)]
pub enum WriteProblem {
    /// The room.
    #[error("the room can't be written: {0}")]
    Glb(#[from] GlbWriteError),
    /// The text.
    #[error("the text can't be written: {0}")]
    Ron(#[from] ron::Error),
    /// The motions' frames.
    #[error("the motions can't be written: {0}")]
    Motions(#[from] std::io::Error),
}

/// Reads the text; checks only that it is a project of a version that is known.
pub(super) fn parse(text: &str, file: &str) -> Result<ProjectText, ProjectError> {
    let project: ProjectText = ron::from_str(text).map_err(|error| ProjectError::Text {
        file: file.to_owned(),
        line: error.span.start.line,
        column: error.span.start.col,
        problem: error.code.to_string(),
    })?;
    if project.format != FORMAT {
        return Err(ProjectError::NotAProject { file: file.to_owned(), found: project.format });
    }
    if project.version > VERSION {
        let (found, known) = (project.version, VERSION);
        return Err(ProjectError::TooNew { file: file.to_owned(), found, known, program: project.program });
    }
    Ok(project)
}

/// Puts text, meshes and frames together again; `motions` are the bytes of the file that the text names.
pub(super) fn assemble(
    text: ProjectText,
    model: Model,
    motions: Option<&[u8]>,
    file: &str,
) -> Result<Project, ProjectError> {
    let expected = text.objects.iter().map(|o| o.object_from_mesh.len()).sum();
    let found = model.parts.len();
    if expected != found {
        return Err(ProjectError::OtherRoom { file: file.to_owned(), expected, found });
    }
    let mut parts = model.parts.into_iter();
    let objects = text.objects.into_iter().map(|object| {
        let taken = parts.by_ref().take(object.object_from_mesh.len());
        let transforms = object.object_from_mesh.iter();
        let parts = taken.zip(transforms).map(|(part, transform)| ObjectPart {
            mesh: part.mesh,
            material: part.material,
            object_from_mesh: affine(transform),
        });
        Object {
            id: object.id,
            parts: parts.collect(),
            name: object.name,
            category: object.category,
            world_from_object: affine(&object.world_from_object),
            visible: object.visible,
            locked: object.locked,
        }
    });
    let room = Room {
        name: text.room.name,
        objects: objects.collect(),
        materials: model.materials,
        textures: model.textures,
    };
    let people = text.people;
    check_people(&people, file)?;
    let clips = match text.motions.zip(motions) {
        Some((text, bytes)) => clips::read(text, bytes, file)?,
        None => Vec::new(),
    };
    let next = NextIds { person: text.next_person, object: text.next_object, clip: text.next_clip };
    Ok(Project { scene: Scene { room: Arc::new(room), people, clips }, next })
}

fn check_people(people: &[Person], file: &str) -> Result<(), ProjectError> {
    for (i, person) in people.iter().enumerate() {
        let finite = person.body.to_vector().iter().all(|x| x.is_finite());
        let unique = people[..i].iter().all(|other| other.id != person.id);
        if !finite || !unique {
            let problem =
                if finite { "has the id of another person" } else { "holds a number that is not finite" };
            return Err(ProjectError::Person { file: file.to_owned(), person: person.name.clone(), problem });
        }
    }
    Ok(())
}

/// The hash of the meshes' file as the text has it.
pub(super) fn hash_text(bytes: &[u8]) -> String {
    format!("{:032x}", content_hash(bytes))
}

/// The same room with each object's parts in the order in which the GLB writer puts them: those that share
/// a transform stand together; meshes without triangles are left out.
fn in_glb_order(room: &Room) -> Room {
    let mut room = room.clone();
    for object in &mut room.objects {
        let mut groups: Vec<Vec<ObjectPart>> = Vec::new();
        for part in std::mem::take(&mut object.parts) {
            if part.mesh.triangles.is_empty() {
                continue;
            }
            let place = |part: &ObjectPart| object.world_from_object * part.object_from_mesh;
            match groups.iter_mut().find(|group| place(&group[0]) == place(&part)) {
                Some(group) => group.push(part),
                None => groups.push(vec![part]),
            }
        }
        object.parts = groups.into_iter().flatten().collect();
    }
    room
}

fn object_text(object: &Object) -> ObjectText {
    ObjectText {
        id: object.id,
        name: object.name.clone(),
        category: object.category,
        visible: object.visible,
        locked: object.locked,
        world_from_object: numbers(&object.world_from_object),
        object_from_mesh: object.parts.iter().map(|p| numbers(&p.object_from_mesh)).collect(),
    }
}

/// Columns of the matrix, then the translation.
fn numbers(transform: &Affine3A) -> [f32; 12] {
    transform.to_cols_array()
}

fn affine(numbers: &[f32; 12]) -> Affine3A {
    let column = |i: usize| Vec3A::new(numbers[3 * i], numbers[3 * i + 1], numbers[3 * i + 2]);
    Affine3A { matrix3: Mat3A::from_cols(column(0), column(1), column(2)), translation: column(3) }
}
