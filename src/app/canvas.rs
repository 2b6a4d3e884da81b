//! Draws the scene into a texture of the window's graphics device and shows it. What has not changed since
//! the last frame is not drawn again. A fault of the graphics device is shown as text, never a crash.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use egui::{Color32, Rect, TextureId, Ui, pos2};
use glam::Vec3;

use super::actors::{self, Actor};
use super::engine::Engine;
use super::motion::Trail;
use super::selection::Item;
use super::state::{EditorState, ViewOptions};
use super::theme;
use crate::render::BodySurface;
use crate::render::Cutaway;
use crate::render::Look;
use crate::render::PersonDraw;
use crate::render::Quality;
use crate::render::RenderContext;
use crate::render::SceneDraw;
use crate::render::Shown;
use crate::render::Viewport;
use crate::scene::BETAS;
use crate::scene::BodyParams;
use crate::scene::Camera;
use crate::scene::Frame;
use crate::scene::ObjectId;
use crate::scene::Person;
use crate::scene::PersonId;
use crate::scene::Room;

/// How much is seen of people being fitted.
const GHOST_ALPHA: f32 = 0.45;
/// How much is seen of the one candidate or earlier body that the user looks at.
const SHOWN_ALPHA: f32 = 0.8;
/// While things move, a software adapter draws every other pixel of every other row: it shares the processor with the
/// job that moves them.
const DRAFT: u32 = 2;
/// Ghosts are drawn this often on a software adapter.
const GHOSTS_EVERY: Duration = Duration::from_millis(500);
/// After this long without a move the picture is drawn at full quality.
const REST: Duration = Duration::from_millis(250);
/// Numbers of ghosts lie apart from those of people, who count from 0.
const GHOST_IDS: u32 = 1 << 31;

/// Vertices of somebody, kept while the body stays the same.
struct Posed {
    shape: Shape,
    vertices: Arc<[Vec3]>,
}

/// What vertices follow from.
#[derive(PartialEq)]
enum Shape {
    Body(BodyParams),
    Frame([f32; BETAS], Frame),
}

/// The room with some objects left out, kept while nothing changes.
struct FilteredRoom {
    of: Arc<Room>,
    view: Option<std::collections::BTreeSet<Item>>,
    room: Arc<Room>,
}

/// The device and everything that is kept from frame to frame.
struct Gpu {
    context: RenderContext,
    egui: egui_wgpu::RenderState,
    viewport: Viewport,
    texture: Option<(TextureId, [u32; 2])>,
}

/// Draws the 3-D view.
#[derive(Default)]
pub struct Canvas {
    gpu: Option<Gpu>,
    fault: Option<String>,
    surface: Option<Arc<BodySurface>>,
    posed: BTreeMap<u32, Posed>,
    filtered: Option<FilteredRoom>,
    drawn: Option<Drawn>,
    drawn_at: Option<Instant>,
    frame_ms: f32,
}

/// What the texture shows; when it is wanted again, nothing is drawn.
#[derive(Clone, PartialEq)]
struct Drawn {
    camera: Camera,
    size: [u32; 2],
    revision: u64,
    heat_ready: u64,
    selected: Vec<Item>,
    hovered: Option<Item>,
    pointed_out: Vec<ObjectId>,
    /// A state of the tree of futures instead of the document.
    life: Option<usize>,
    ghosts: Vec<Person>,
    actors: Vec<Actor>,
    /// The way that is drawn: its clip, by address, and how.
    way: (usize, Trail),
    view: ViewOptions,
    /// The theme's colour behind everything, which follows the view's options a frame later.
    background: [u8; 3],
    moving: bool,
}

impl Drawn {
    /// What every picture of the present view has; nothing is pointed at.
    fn of_view(state: &EditorState) -> Self {
        Self {
            camera: state.orbit.camera(),
            size: [1, 1],
            revision: state.document.revision(),
            heat_ready: state.measurements,
            selected: Vec::new(),
            hovered: None,
            pointed_out: Vec::new(),
            life: None,
            ghosts: Vec::new(),
            actors: Vec::new(),
            way: (0, Trail::Off),
            view: state.view.clone(),
            background: [0; 3],
            moving: false,
        }
    }
}

impl Canvas {
    /// A canvas on the window's device; without one it says so where the picture would be.
    pub fn new(egui: Option<&egui_wgpu::RenderState>) -> Self {
        let Some(egui) = egui else {
            let fault = "There is no graphics adapter, so the room can't be drawn.".to_owned();
            return Self { fault: Some(fault), ..Self::default() };
        };
        match RenderContext::from_device(egui.device.clone(), egui.queue.clone()) {
            Ok(context) => {
                let gpu = Gpu { context, egui: egui.clone(), viewport: Viewport::default(), texture: None };
                Self { gpu: Some(gpu), ..Self::default() }
            }
            Err(error) => Self { fault: Some(error.to_string()), ..Self::default() },
        }
    }

    /// Name of the adapter; empty without one.
    pub fn adapter(&self) -> String {
        self.gpu.as_ref().map_or(String::new(), |gpu| gpu.egui.adapter.get_info().name)
    }

    /// Milliseconds that the last drawing took on this side of the device.
    pub fn frame_ms(&self) -> f32 {
        self.frame_ms
    }

    /// Shows the scene in `rect`.
    pub fn show(&mut self, ui: &Ui, rect: Rect, state: &EditorState, hovered: Option<Item>) {
        let of_document = Drawn {
            selected: state.selection.iter().collect(),
            hovered,
            pointed_out: state.living.pointed_out.clone(),
            life: state.replayed(),
            ghosts: state.shown_ghosts(),
            actors: actors::actors(state, hovered),
            way: actors::way_key(state),
            ..Drawn::of_view(state)
        };
        self.show_as(ui, rect, state, of_document);
    }

    /// Shows another state of the tree of futures in `rect`, from the same camera.
    pub fn show_life(&mut self, ui: &Ui, rect: Rect, state: &EditorState, life: usize) {
        self.show_as(ui, rect, state, Drawn { life: Some(life), ..Drawn::of_view(state) });
    }

    fn show_as(&mut self, ui: &Ui, rect: Rect, state: &EditorState, wanted: Drawn) {
        let background = theme::palette(ui.visuals()).background;
        let [r, g, b] = background;
        ui.painter().rect_filled(rect, 0.0, Color32::from_rgb(r, g, b));
        if !state.has_room() {
            return;
        }
        let scale = ui.ctx().pixels_per_point();
        let size = [(rect.width() * scale).round() as u32, (rect.height() * scale).round() as u32];
        let slow = self.gpu.as_ref().is_some_and(|gpu| gpu.context.is_software());
        let busy = state.jobs.populating() || state.motion.player.playing;
        let moving = slow && (is_moving(ui) || busy);
        let coarser = if moving { DRAFT } else { 1 };
        let size = size.map(|side| (side / coarser).max(1));
        let wanted = Drawn { size, moving, background, ..wanted };
        if let Some(rest) = self.ghosts_may_wait(&wanted, slow) {
            ui.ctx().request_repaint_after(rest);
        } else if self.drawn.as_ref() != Some(&wanted) {
            self.draw(state, &wanted);
            self.drawn = Some(wanted);
            self.drawn_at = Some(Instant::now());
        }
        if moving {
            // One more picture at full quality once all rests.
            ui.ctx().request_repaint_after(REST);
        }
        self.paint(ui, rect);
    }

    /// How long ghosts that have moved may wait for a new picture: on a software adapter drawing each of
    /// their steps would take the processor from the fit itself. `None` when something else has changed.
    fn ghosts_may_wait(&self, wanted: &Drawn, slow: bool) -> Option<Duration> {
        let drawn = self.drawn.as_ref().filter(|drawn| slow && drawn.ghosts != wanted.ghosts)?;
        let as_drawn = Drawn { ghosts: drawn.ghosts.clone(), ..wanted.clone() };
        let rest = GHOSTS_EVERY.checked_sub(self.drawn_at?.elapsed())?;
        (*drawn == as_drawn && !wanted.ghosts.is_empty()).then_some(rest)
    }

    fn paint(&self, ui: &Ui, rect: Rect) {
        if let Some(fault) = &self.fault {
            let style = egui::TextStyle::Body.resolve(ui.style());
            let color = ui.visuals().error_fg_color;
            let galley = ui.painter().layout(fault.clone(), style, color, rect.width() - 48.0);
            ui.painter().galley(rect.center() - galley.size() * 0.5, galley, color);
        } else if let Some((texture, _)) = self.gpu.as_ref().and_then(|gpu| gpu.texture) {
            let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
            ui.painter().image(texture, rect, whole, Color32::WHITE);
        }
    }

    fn draw(&mut self, state: &EditorState, wanted: &Drawn) {
        let started = Instant::now();
        if self.gpu.is_none() {
            return;
        }
        let scene = self.scene(state, wanted);
        let Some(gpu) = &mut self.gpu else { return };
        match gpu.viewport.render(&gpu.context, &scene, &wanted.camera, wanted.size) {
            Ok(()) => {
                self.fault = None;
                gpu.show_texture();
            }
            Err(error) => self.fault = Some(error.to_string()),
        }
        self.frame_ms = started.elapsed().as_secs_f32() * 1e3;
    }

    fn scene(&mut self, state: &EditorState, wanted: &Drawn) -> SceneDraw {
        let surface = self.surface.get_or_insert_with(|| state.engine().surface()).clone();
        let yes_no = |yes: bool| if yes { Shown::Yes } else { Shown::No };
        let look = Look {
            quality: if wanted.moving { Quality::Low } else { Quality::High },
            cutaway: if state.view.cutaway { Cutaway::Outside } else { Cutaway::Off },
            grid: yes_no(state.view.grid),
            legend: Shown::No,
            background: wanted.background,
        };
        let objects = wanted.selected.iter().filter_map(|item| match item {
            Item::Object(id) => Some(*id),
            _ => None,
        });
        let mut selected_objects: Vec<ObjectId> = objects.collect();
        if let Some(Item::Object(id)) = wanted.hovered.filter(|_| state.tool == super::state::Tool::PutHere) {
            selected_objects.push(id);
        }
        selected_objects.extend(&wanted.pointed_out);
        let people = self.people(state, wanted);
        let room = self.room(state, wanted.life);
        let lines = if wanted.life.is_some() { Vec::new() } else { actors::way(state) };
        SceneDraw { room, body: Some(surface), people, selected_objects, lines, look, ..SceneDraw::default() }
    }

    fn people(&mut self, state: &EditorState, wanted: &Drawn) -> Vec<PersonDraw> {
        let engine = state.engine().clone();
        let only = state.view.isolated.as_ref();
        let clips = state.shown_clips();
        let shown = |p: &&Person| {
            let wanted = only.is_none_or(|only| only.contains(&Item::Person(p.id)));
            p.visible && wanted && !super::motion::moves(&clips, p.id)
        };
        let of_life = wanted.life.and_then(|number| state.life_scene(number));
        let there = of_life.map_or(state.document.scene().people.as_slice(), |(_, people)| people);
        let solid = there.iter().filter(shown).map(|person| {
            let mut draw =
                PersonDraw::new(person.id, self.pose(&engine, person.id.0, &person.body), person.palette);
            let item = Item::Person(person.id);
            draw.selected = wanted.selected.contains(&item) || wanted.hovered == Some(item);
            draw.heat = state.shown_distances_m(person.id).filter(|_| of_life.is_none());
            draw
        });
        let mut people: Vec<PersonDraw> = solid.collect();
        for (i, ghost) in wanted.ghosts.iter().enumerate() {
            let id = GHOST_IDS + i as u32;
            let vertices = self.pose(&engine, id, &ghost.body);
            let mut draw = PersonDraw::new(PersonId(id), vertices, ghost.palette);
            draw.alpha = if state.ghosts.is_empty() { SHOWN_ALPHA } else { GHOST_ALPHA };
            people.push(draw);
        }
        for actor in &wanted.actors {
            let vertices = self.pose_frame(&engine, actor);
            let mut draw = PersonDraw::new(PersonId(actor.id), vertices, actor.palette);
            (draw.alpha, draw.selected) = (actor.alpha, actor.selected);
            people.push(draw);
        }
        let alive: Vec<u32> = people.iter().map(|p| p.id.0).collect();
        self.posed.retain(|id, _| alive.contains(id));
        people
    }

    fn pose(&mut self, engine: &Arc<dyn Engine>, id: u32, body: &BodyParams) -> Arc<[Vec3]> {
        match self.posed.get(&id) {
            Some(Posed { shape: Shape::Body(of), vertices }) if of == body => vertices.clone(),
            _ => {
                let vertices = engine.pose(body);
                let shape = Shape::Body(body.clone());
                self.posed.insert(id, Posed { shape, vertices: vertices.clone() });
                vertices
            }
        }
    }

    fn pose_frame(&mut self, engine: &Arc<dyn Engine>, actor: &Actor) -> Arc<[Vec3]> {
        let shape = Shape::Frame(actor.betas, actor.frame.clone());
        match self.posed.get(&actor.id) {
            Some(posed) if posed.shape == shape => posed.vertices.clone(),
            _ => {
                let vertices = engine.pose_frame(&actor.betas, &actor.frame);
                self.posed.insert(actor.id, Posed { shape, vertices: vertices.clone() });
                vertices
            }
        }
    }

    /// The room without what isolation leaves out; the same `Arc` while nothing changes.
    fn room(&mut self, state: &EditorState, life: Option<usize>) -> Arc<Room> {
        let of_life = life.and_then(|number| state.life_scene(number));
        let room = of_life.map_or(&state.document.scene().room, |(room, _)| room);
        let Some(only) = &state.view.isolated else { return room.clone() };
        if let Some(filtered) = &self.filtered
            && Arc::ptr_eq(&filtered.of, room)
            && filtered.view.as_ref() == Some(only)
        {
            return filtered.room.clone();
        }
        let mut shown = room.as_ref().clone();
        shown.objects.retain(|o| only.contains(&Item::Object(o.id)));
        let shown = Arc::new(shown);
        self.filtered =
            Some(FilteredRoom { of: room.clone(), view: Some(only.clone()), room: shown.clone() });
        shown
    }
}

/// Whether the mouse does something, so that pictures have to be quick rather than fine.
fn is_moving(ui: &Ui) -> bool {
    ui.input(|i| i.pointer.any_down() || i.pointer.is_moving() || i.smooth_scroll_delta.y != 0.0)
}

impl Gpu {
    /// Makes egui show the texture that was drawn; it is a new one whenever the size has changed.
    fn show_texture(&mut self) {
        let (Some(view), Some(size)) = (self.viewport.view(), self.viewport.size()) else { return };
        let device = &self.egui.device;
        let mut renderer = self.egui.renderer.write();
        match self.texture {
            Some((_, of)) if of == size => {}
            Some((id, _)) => {
                renderer.update_egui_texture_from_wgpu_texture(device, view, wgpu::FilterMode::Linear, id);
                self.texture = Some((id, size));
            }
            None => {
                let id = renderer.register_native_texture(device, view, wgpu::FilterMode::Linear);
                self.texture = Some((id, size));
            }
        }
    }
}
