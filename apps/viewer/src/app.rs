//! The window: input, the picture of the scene, and the panels around it.

use crate::counts::{counted, grouped};
use crate::floor_plan;
use crate::history::{self, Frame, History};
use crate::loading::{Loading, Opened};
use crate::occluders::Occluders;
use crate::overlay::{self, Overlays};
#[cfg(not(target_arch = "wasm32"))]
use crate::path;
use crate::picture::{Diagnostic, Gpu, ScenePicture};
use crate::session::Session;
use crate::steps::StepMode;
use crate::walker::Walker;
use eframe::egui::{self, Color32, ComboBox, Key, RichText, Sense, Slider, Ui, Vec2};
use enfilade::{Camera, Method, SectorId, View};
use enfilade_draw::{Exposure, Show};
use enfilade_wgpu::DrawStats;
use web_time::Instant;

/// Most that a menu is high, in points.
const MENU_HEIGHT: f32 = 480.0;

/// The viewer.
pub struct App {
    gpu: Gpu,
    picture: ScenePicture,
    /// The walk through the scene, once there is one.
    pub session: Option<Session>,
    loading: Option<Loading>,
    /// The last message, and whether it is an error.
    pub message: Option<(String, bool)>,
    /// What is drawn over the picture.
    pub overlays: Overlays,
    /// Whether the panels are shown.
    pub panels: bool,
    occluders: Occluders,
    diagnostic: Option<Diagnostic>,
    /// The look that is stepped through, and the picture of its cover.
    pub steps: Option<StepMode>,
    cover: Option<egui::TextureHandle>,
    history: History,
    drawn: DrawStats,
    encode_ms: f64,
    /// Metres per second.
    speed: f64,
    exposure_stops: f32,
    recording: Option<Vec<Camera>>,
    replay: Option<(Vec<Camera>, usize)>,
    /// The last recorded or opened path.
    path: Vec<Camera>,
    /// Part of the name of an item to find.
    wanted: String,
    /// Seconds to go on repainting.
    awake: f64,
}

impl App {
    /// Creates a viewer of a scene, which it begins to load.
    pub fn new(gpu: Gpu, scene: Loading) -> App {
        App {
            picture: ScenePicture::new(&gpu, 4),
            gpu,
            session: None,
            loading: Some(scene),
            message: None,
            overlays: Overlays::default(),
            panels: true,
            occluders: Occluders::default(),
            diagnostic: None,
            steps: None,
            cover: None,
            history: History::default(),
            drawn: DrawStats::default(),
            encode_ms: 0.0,
            speed: 2.0,
            exposure_stops: 0.0,
            recording: None,
            replay: None,
            path: Vec::new(),
            wanted: String::new(),
            awake: 0.0,
        }
    }

    /// Shows a frame.
    pub fn show(&mut self, ui: &mut Ui) {
        ui.ctx().set_theme(egui::Theme::Dark);
        // A list that goes on below its edge shows that it does.
        ui.ctx()
            .all_styles_mut(|style| style.spacing.scroll = egui::style::ScrollStyle::solid());
        self.take_scene(ui);
        self.take_files(ui);
        if self.panels {
            egui::Panel::bottom("status").show(ui, |ui| self.status(ui));
            if self.session.is_some() {
                egui::Panel::left("scene").default_size(230.0).show(ui, |ui| {
                    egui::ScrollArea::vertical().show(ui, |ui| self.scene_panel(ui));
                });
                egui::Panel::right("visibility")
                    .default_size(360.0)
                    .show(ui, |ui| {
                        egui::ScrollArea::vertical().show(ui, |ui| self.visibility_panel(ui));
                    });
            }
        }
        egui::CentralPanel::no_frame().show(ui, |ui| self.viewport(ui));
        if self.awake > 0.0 || self.loading.is_some() || self.replay.is_some() {
            ui.ctx().request_repaint();
        }
    }

    fn take_scene(&mut self, ui: &Ui) {
        let Some(loading) = &mut self.loading else { return };
        match loading.poll() {
            None => return,
            Some(Ok(Opened::Path(path))) => {
                self.message = Some((format!("{}: {} views", loading.name(), path.len()), false));
                self.path = path;
            }
            Some(Ok(Opened::Scene(world))) => {
                let world = *world;
                self.message = world.warnings.first().map(|warning| (warning.clone(), false));
                self.speed = 2.0;
                self.session = Some(Session::new(world));
                self.occluders = Occluders::default();
                self.show_diagnostic(self.diagnostic.as_ref().map(|diagnostic| diagnostic.show));
                self.steps = None;
                // Meshes and textures of the last scene go.
                self.picture = ScenePicture::new(&self.gpu, self.picture.samples());
                self.history = History::default();
            }
            Some(Err(why)) => self.message = Some((format!("{why:#}"), true)),
        }
        self.loading = None;
        ui.ctx().request_repaint();
    }

    /// Opens a file that was dropped on the window.
    fn take_files(&mut self, ui: &Ui) {
        let dropped = ui.input(|input| input.raw.dropped_files.first().cloned());
        if let Some(file) = dropped {
            self.load(Loading::dropped(file));
        }
    }

    /// Replaces the scene once the other one is loaded.
    pub fn load(&mut self, loading: Loading) {
        self.loading = Some(loading);
    }

    /// Replays a camera path.
    pub fn replay(&mut self, path: Vec<Camera>) {
        self.replay = Some((path.clone(), 0));
        self.path = path;
    }

    /// Lets the sun of the scene cast shadows; a scene without lights gets one.
    pub fn cast_shadows(&mut self) {
        if let Some(session) = self
            .session
            .as_mut()
            .filter(|session| session.world.scene.lights().is_empty())
        {
            session.world.add_sun();
        }
        self.picture.shadows = true;
    }

    /// Shows a diagnostic picture beside the scene, or none.
    pub fn show_diagnostic(&mut self, show: Option<Show>) {
        self.diagnostic = show.map(Diagnostic::new);
    }

    fn say(&mut self, message: &str) {
        self.message = Some((message.to_owned(), false));
    }

    fn status(&mut self, ui: &mut Ui) {
        ui.horizontal_wrapped(|ui| {
            if let Some(loading) = &self.loading {
                ui.spinner();
                ui.label(loading.progress());
            }
            match &self.message {
                Some((message, true)) => ui.colored_label(Color32::from_rgb(255, 120, 100), message),
                Some((message, false)) => ui.label(message),
                None => ui.label("Drop a .glb, .gltf, .obj, .bsp or .enf file here to open it."),
            };
        });
        ui.horizontal_wrapped(|ui| {
            let keys = [
                ("drag", "look around"),
                ("W A S D Q E", "move"),
                ("Shift", "faster"),
                ("click", "why is it visible"),
                ("F", "freeze and see from outside"),
                ("right click", "open or close a door"),
                ("G", "walk"),
                ("Tab", "panels"),
            ];
            for (key, what) in keys {
                ui.label(RichText::new(key).strong());
                ui.label(RichText::new(what).weak());
            }
        });
    }

    fn scene_panel(&mut self, ui: &mut Ui) {
        let Some(session) = &mut self.session else { return };
        let scene = &session.world.scene;
        ui.add_space(4.0);
        ui.heading(session.world.name.rsplit('/').next().unwrap_or_default());
        ui.label(format!(
            "{}, {}, {}, {}",
            counted(scene.item_count() as u64, "item"),
            counted(scene.triangle_count(), "triangle"),
            counted(scene.sector_count() as u64, "sector"),
            counted(scene.portals().len() as u64, "portal")
        ));
        let mut built_in = None;
        ComboBox::from_id_salt("built-in")
            .selected_text("built-in scenes")
            .height(MENU_HEIGHT)
            .show_ui(ui, |ui| {
                for name in enfilade_scenes::NAMES {
                    if ui.selectable_label(false, name).clicked() {
                        built_in = Some(name);
                    }
                }
            });
        let mut camera = None;
        ComboBox::from_id_salt("cameras")
            .selected_text("cameras")
            .height(MENU_HEIGHT)
            .show_ui(ui, |ui| {
                for (number, known) in session.world.cameras.iter().enumerate() {
                    let name = match known.name.as_str() {
                        "" => format!("camera {}", number + 1),
                        name => name.to_owned(),
                    };
                    if ui.selectable_label(false, name).clicked() {
                        camera = Some(number);
                    }
                }
            });
        if let Some(number) = camera {
            if session.frozen.is_some() {
                session.toggle_frozen();
            }
            let world = &session.world;
            session.walker = Walker::new(&world.scene, &world.cameras[number], world.metre);
        }
        ui.separator();
        Self::methods(ui, session, &mut self.message);
        ui.separator();
        let mut options = session.viewer.options;
        ui.checkbox(&mut options.occlusion, "occlusion culling");
        ui.checkbox(&mut options.coherence, "temporal coherence");
        ui.add(Slider::new(&mut options.limits.max_crossings, 0..=64).text("portals in a row"))
            .on_hover_text("How many portals and mirrors are followed, one behind the other.");
        if options != session.viewer.options {
            session.viewer.options = options;
            session.look_again();
        }
        ui.separator();
        let mut walks = session.walker.walks;
        if ui.checkbox(&mut walks, "walk on the ground (G)").changed() && session.frozen.is_none() {
            session.walker.set_walks(&session.world.scene, walks);
            self.awake = 3.0;
        }
        ui.add(
            Slider::new(&mut self.speed, 0.1..=200.0)
                .logarithmic(true)
                .text("m/s"),
        );
        if !session.world.scene.lights().is_empty() {
            ui.add(Slider::new(&mut self.exposure_stops, -4.0..=4.0).text("exposure"));
        }
        let mut shadows = self.picture.shadows;
        if ui.checkbox(&mut shadows, "shadows of the sun").changed() {
            if session.world.scene.lights().is_empty() {
                session.world.add_sun();
                session.look_again();
            }
            self.picture.shadows = shadows;
        }
        let mut smooth = self.picture.samples() > 1;
        if ui.checkbox(&mut smooth, "smooth edges").changed() {
            self.picture = ScenePicture::new(&self.gpu, if smooth { 4 } else { 1 });
            self.picture.shadows = shadows;
        }
        ui.separator();
        self.path_controls(ui);
        if let Some(name) = built_in {
            self.load(Loading::file(&format!("@{name}")));
        }
    }

    fn methods(ui: &mut Ui, session: &mut Session, message: &mut Option<(String, bool)>) {
        let here = session
            .viewer
            .visible()
            .passages()
            .first()
            .map(|passage| passage.sector);
        let all: Vec<Option<Method>> = (session.world.scene.sectors())
            .map(|id| session.world.scene.method(id))
            .collect();
        let same = all
            .first()
            .copied()
            .flatten()
            .filter(|&first| all.iter().all(|&other| other == Some(first)));
        let mut wanted: Option<(Method, Option<SectorId>)> = None;
        let mut pick = |ui: &mut Ui, label: &str, now: Option<Method>, only: Option<SectorId>| {
            let text = now.map_or("several", Method::name);
            let menu = ComboBox::from_label(label)
                .selected_text(text)
                .height(MENU_HEIGHT);
            let shown = menu.show_ui(ui, |ui| {
                for method in Method::ALL {
                    let line = format!("{} · {}", method.name(), method.contract());
                    if ui.selectable_label(now == Some(method), line).clicked() {
                        wanted = Some((method, only));
                    }
                }
            });
            if now.is_none() {
                shown
                    .response
                    .on_hover_text("Sectors use different methods. Choose one here to use it in all.");
            }
        };
        pick(ui, "method", same, None);
        if let Some(sector) = here.filter(|_| all.len() > 1) {
            pick(
                ui,
                "in this sector",
                session.world.scene.method(sector),
                Some(sector),
            );
            ui.label(RichText::new(session.world.scene.sector_name(sector)).weak());
        }
        if let Some((method, only)) = wanted {
            *message = match session.set_method(method, only) {
                Ok(()) => None,
                Err(why) => Some((why, true)),
            };
        }
    }

    fn path_controls(&mut self, ui: &mut Ui) {
        ui.horizontal(|ui| match self.recording.take() {
            Some(recorded) => {
                if ui.button(format!("stop ({} views)", recorded.len())).clicked() {
                    self.path = recorded;
                } else {
                    self.recording = Some(recorded);
                }
            }
            None => {
                if ui.button("record a camera path").clicked() {
                    self.recording = Some(Vec::new());
                }
            }
        });
        if self.path.is_empty() {
            ui.label(RichText::new("Or drop a .jsonl file of views.").weak());
            return;
        }
        ui.horizontal(|ui| {
            let label = if self.replay.is_some() { "stop" } else { "replay" };
            if ui
                .button(format!("{label} ({} views)", self.path.len()))
                .clicked()
            {
                self.replay = match self.replay.take() {
                    Some(_) => None,
                    None => Some((self.path.clone(), 0)),
                };
            }
            #[cfg(not(target_arch = "wasm32"))]
            if ui.button("save").clicked() {
                self.message = Some(match path::save(&self.path) {
                    Ok(file) => (
                        format!("wrote {file}; `enfilade look SCENE --path {file}` measures it"),
                        false,
                    ),
                    Err(why) => (format!("{why:#}"), true),
                });
            }
        });
    }

    fn visibility_panel(&mut self, ui: &mut Ui) {
        let Some(session) = &mut self.session else { return };
        let stats = session.stats;
        ui.add_space(4.0);
        egui::Grid::new("numbers")
            .num_columns(3)
            .striped(true)
            .show(ui, |ui| {
                ui.label("");
                ui.label(RichText::new("visible").strong());
                ui.label(RichText::new("in the frustum").weak())
                    .on_hover_text("What frustum culling alone would leave of the visible sectors.");
                ui.end_row();
                ui.label("items");
                ui.label(RichText::new(grouped(stats.items as u64)).strong());
                ui.label(grouped(stats.items_in_frustum as u64));
                ui.end_row();
                ui.label("triangles");
                ui.label(RichText::new(grouped(stats.triangles)).strong());
                ui.label(grouped(stats.triangles_in_frustum));
                ui.end_row();
                ui.label("passages")
                    .on_hover_text("A passage is one way of seeing a sector: the camera's own, or through a chain of portals.");
                ui.label(grouped(stats.passages as u64));
                ui.label(if stats.complete { "" } else { "limit reached" });
                ui.end_row();
                ui.label(match session.frozen {
                    None => "draw calls",
                    Some(_) => "draw calls, with ghosts",
                });
                ui.label(grouped(self.drawn.draw_calls.into()));
                ui.end_row();
            });
        ui.separator();
        let label = if session.frozen.is_some() {
            "unfreeze (F)"
        } else {
            "freeze the visible set (F)"
        };
        ui.horizontal(|ui| {
            if ui.button(label).clicked() {
                session.toggle_frozen();
                self.awake = 0.5;
            }
            if session.frozen.is_some() && ui.button("from above").clicked() {
                session.rise();
                self.awake = 0.5;
            }
        });
        ui.horizontal_wrapped(|ui| {
            let is_frozen = session.frozen.is_some();
            for (name, shown) in self.overlays.all() {
                let is_drawn = is_frozen || matches!(name, "apertures" | "occluders");
                ui.add_enabled(is_drawn, egui::Checkbox::new(shown, name))
                    .on_disabled_hover_text("Drawn while the set is frozen.");
            }
            let ghosts = egui::Checkbox::new(&mut session.ghosts, "ghosts");
            let ghosts = ui.add_enabled(is_frozen, ghosts);
            if ghosts
                .on_disabled_hover_text("Drawn while the set is frozen.")
                .changed()
            {
                session.place();
            }
        });
        if let Some(frozen) = &session.frozen {
            ui.label("Fly out of it, or press `from above`. Ghosts: red items are in view but hidden, blue ones are out of view.");
            if frozen.left_out > 0 {
                let text = format!("{} more ghosts are not drawn.", grouped(frozen.left_out as u64));
                ui.label(RichText::new(text).weak());
            }
        }
        ui.separator();
        ui.horizontal(|ui| {
            ui.label("find");
            ui.text_edit_singleline(&mut self.wanted);
        });
        if !self.wanted.is_empty() {
            for (sector, item, name) in session.find(&self.wanted, 8) {
                let line = format!("{name} · {}", session.world.scene.sector_name(sector));
                if ui.selectable_label(false, line).clicked() {
                    session.select_item(sector, item);
                    self.wanted.clear();
                }
            }
        }
        match &session.selected {
            None => {
                ui.label(RichText::new("Click an item to see why it is visible, or not.").weak());
            }
            Some(selected) => {
                let explanation = &selected.explanation;
                ui.label(RichText::new(&explanation.name).strong());
                let (verdict, color) = match explanation.is_visible {
                    true => ("visible", Color32::from_rgb(90, 220, 120)),
                    false => ("not visible", Color32::from_rgb(255, 120, 100)),
                };
                ui.colored_label(color, verdict);
                for reason in &explanation.reasons {
                    ui.label(reason);
                }
            }
        }
        ui.separator();
        egui::CollapsingHeader::new("the last seconds")
            .default_open(ui.ctx().content_rect().height() > 900.0)
            .show(ui, |ui| plots(ui, &self.history));
        let mut show = self.diagnostic.as_ref().map(|diagnostic| diagnostic.show);
        let name = |show: Option<Show>| show.map_or("none", Show::name);
        ComboBox::from_label("diagnostic picture")
            .selected_text(name(show))
            .show_ui(ui, |ui| {
                ui.selectable_value(&mut show, None, "none");
                for kind in Show::ALL.into_iter().filter(|&kind| kind != Show::Image) {
                    ui.selectable_value(&mut show, Some(kind), kind.name());
                }
            });
        if show != self.diagnostic.as_ref().map(|diagnostic| diagnostic.show) {
            self.diagnostic = show.map(Diagnostic::new);
        }
        if let Some(diagnostic) = &mut self.diagnostic {
            let width = ui.available_width();
            let pixels = (width * ui.ctx().pixels_per_point()) as u32;
            // Legends need 320 pixels.
            let texture = diagnostic.draw(ui.ctx(), session, pixels.clamp(320, 1024));
            let size = Vec2::new(width, width * texture.size.y / texture.size.x);
            ui.add(egui::Image::from_texture(texture).fit_to_exact_size(size));
        }
        Self::step_controls(ui, session, &mut self.steps, &mut self.cover);
        egui::CollapsingHeader::new("floor plan")
            .default_open(true)
            .show(ui, |ui| floor_plan::show(ui, session));
        let memory = format!(
            "{:.0} MB on {}",
            self.picture.bytes() as f64 / 1e6,
            self.gpu.adapter
        );
        ui.label(RichText::new(memory).weak());
    }

    /// Step mode: the number of steps done, what the last did, and the cover after it.
    fn step_controls(
        ui: &mut Ui,
        session: &Session,
        steps: &mut Option<StepMode>,
        texture: &mut Option<egui::TextureHandle>,
    ) {
        if steps.as_ref().is_some_and(|mode| !mode.is_of(session)) {
            *steps = None;
        }
        let mut wanted = steps.is_some();
        ui.checkbox(&mut wanted, "step through the look (, and .)");
        if wanted != steps.is_some() {
            *steps = wanted.then(|| StepMode::new(session));
            *texture = None;
        }
        let Some(mode) = steps else { return };
        let (mut done, most) = (mode.done, mode.all.len());
        ui.horizontal(|ui| {
            if ui.button("<").clicked() {
                done = done.saturating_sub(1);
            }
            if ui.button(">").clicked() {
                done += 1;
            }
            ui.add(Slider::new(&mut done, 0..=most).text(format!("of {most}")));
        });
        let has_keys = !ui.ctx().egui_wants_keyboard_input();
        let pressed = |key| {
            if has_keys {
                ui.input(|input| input.num_presses(key))
            } else {
                0
            }
        };
        done = (done + pressed(Key::Period))
            .saturating_sub(pressed(Key::Comma))
            .min(most);
        if done != mode.done {
            mode.go_to(session, done);
            *texture = None;
        }
        ui.label(mode.text(session));
        let texture = texture.get_or_insert_with(|| {
            let size = [mode.cover.width() as usize, mode.cover.height() as usize];
            let image = egui::ColorImage::from_rgb(size, mode.cover.as_raw());
            ui.ctx()
                .load_texture("cover", image, egui::TextureOptions::NEAREST)
        });
        let size = texture.size_vec2();
        let width = ui.available_width();
        let shown = egui::load::SizedTexture::new(texture.id(), size);
        ui.add(egui::Image::from_texture(shown).fit_to_exact_size(Vec2::new(width, width * size.y / size.x)));
    }

    fn viewport(&mut self, ui: &mut Ui) {
        let rect = ui.available_rect_before_wrap();
        let response = ui.allocate_rect(rect, Sense::click_and_drag());
        let Some(session) = &mut self.session else {
            self.without_scene(ui, rect);
            return;
        };
        let scale = ui.ctx().pixels_per_point();
        let size = [rect.width(), rect.height()].map(|side| ((side * scale) as u32).clamp(1, 8192));
        let seconds = ui.input(|input| f64::from(input.stable_dt.min(0.1)));
        self.awake -= seconds;
        let has_keys = !ui.ctx().egui_wants_keyboard_input();
        let (mut freeze, mut panels, mut walk) = (false, false, false);
        ui.input(|input| {
            if has_keys {
                // Not again while a key is held.
                let pressed = |wanted| {
                    let is_press = |event: &egui::Event| matches!(event, egui::Event::Key { key, pressed: true, repeat: false, .. } if *key == wanted);
                    input.events.iter().any(is_press)
                };
                freeze = pressed(Key::F);
                panels = pressed(Key::Tab);
                walk = pressed(Key::G);
                let held = |key| f64::from(u8::from(input.key_down(key)));
                let either = |a, b| held(a).max(held(b));
                let way = [
                    either(Key::D, Key::ArrowRight) - either(Key::A, Key::ArrowLeft),
                    either(Key::E, Key::PageUp) - either(Key::Q, Key::PageDown),
                    either(Key::W, Key::ArrowUp) - either(Key::S, Key::ArrowDown),
                ];
                let is_moving = way != [0.0; 3];
                if is_moving {
                    self.awake = 0.5;
                }
                if is_moving || session.walker.walks {
                    let speed = self.speed * if input.modifiers.shift { 4.0 } else { 1.0 };
                    session
                        .walker
                        .step(&session.world.scene, way.map(|part| part * speed), seconds);
                }
            }
        });
        if panels {
            self.panels = !self.panels;
        }
        if freeze {
            session.toggle_frozen();
            self.awake = 0.5;
        }
        if walk && session.frozen.is_none() {
            let walks = !session.walker.walks;
            session.walker.set_walks(&session.world.scene, walks);
            self.awake = 3.0;
        }
        if response.hovered() {
            let scrolled = ui.input(|input| input.smooth_scroll_delta.y);
            self.speed = (self.speed * f64::from(0.004 * scrolled).exp()).clamp(0.1, 200.0);
        }
        if response.dragged() {
            let moved = response.drag_delta();
            session
                .walker
                .turn(0.004 * f64::from(moved.x), -0.004 * f64::from(moved.y));
            self.awake = 0.5;
        }
        if let Some((path, next)) = &mut self.replay {
            match path.get(*next).filter(|_| session.frozen.is_none()) {
                Some(camera) => {
                    session.walker = Walker::new(&session.world.scene, camera, session.world.metre)
                }
                None => self.replay = None,
            }
            if let Some((_, next)) = &mut self.replay {
                *next += 1;
            }
        }
        let view = session.look(size);
        if let Some(recorded) = self.recording.as_mut().filter(|_| session.frozen.is_none()) {
            recorded.push(session.walker.camera(&session.world.scene));
        }
        let start = Instant::now();
        let exposure = match session.world.scene.lights().is_empty() {
            true => Exposure::Fixed(1.0),
            false => Exposure::Eye(self.exposure_stops),
        };
        let (texture, drawn) = self.picture.draw(&self.gpu, session, &view, exposure);
        self.encode_ms = start.elapsed().as_secs_f64() * 1e3;
        self.drawn = drawn;
        if session.frozen.is_none() {
            self.history.push(Frame {
                look_ms: session.stats.look_ms,
                encode_ms: self.encode_ms,
                items: session.stats.items as f64,
                items_in_frustum: session.stats.items_in_frustum as f64,
                triangles: session.stats.triangles as f64,
                triangles_in_frustum: session.stats.triangles_in_frustum as f64,
                draw_calls: drawn.draw_calls.into(),
                passages: session.stats.passages as f64,
            });
        }
        let whole = egui::Rect::from_min_max(egui::pos2(0.0, 0.0), egui::pos2(1.0, 1.0));
        ui.painter().image(texture.id, rect, whole, Color32::WHITE);
        let occluders = match self.overlays.occluders {
            true => self.occluders.of(session),
            false => &[],
        };
        overlay::draw(ui.painter(), rect, session, &view, self.overlays, occluders);
        if let Some(steps) = self.steps.as_ref().filter(|_| session.frozen.is_none()) {
            steps.draw(ui.painter(), rect);
        }
        if let Some(at) = response.interact_pointer_pos() {
            self.pointed(
                &response,
                &view,
                [
                    f64::from((at.x - rect.min.x) * scale),
                    f64::from((at.y - rect.min.y) * scale),
                ],
            );
        }
    }

    /// Shows what is being opened, or why it cannot be.
    fn without_scene(&mut self, ui: &mut Ui, rect: egui::Rect) {
        ui.painter().rect_filled(rect, 0.0, Color32::from_rgb(18, 20, 26));
        let text = match (&self.loading, &self.message) {
            (Some(loading), _) => loading.progress(),
            (None, Some((message, _))) => message.clone(),
            (None, None) => String::new(),
        };
        let middle = egui::Rect::from_center_size(rect.center(), Vec2::new(0.8 * rect.width(), 120.0));
        let inside = egui::UiBuilder::new().max_rect(middle);
        ui.scope_builder(inside, |ui| {
            ui.vertical_centered(|ui| {
                ui.label(RichText::new(text).size(16.0));
                if self.loading.is_none() && ui.button("open the palace instead").clicked() {
                    self.load(Loading::file("@enfilade"));
                }
            });
        });
    }

    fn pointed(&mut self, response: &egui::Response, view: &View, at: [f64; 2]) {
        let Some(session) = &mut self.session else { return };
        if response.clicked() {
            session.select(view, at);
            self.awake = 0.1;
        }
        if response.secondary_clicked() {
            let said = session.toggle_portal(view, at);
            let said = said.unwrap_or_else(|| "No portal is there.".to_owned());
            self.say(&said);
            self.awake = 0.1;
        }
    }
}

/// Shows the numbers of the last seconds.
fn plots(ui: &mut Ui, history: &History) {
    let (look, encode) = (Color32::from_rgb(120, 200, 255), Color32::from_rgb(255, 180, 90));
    let (visible, others) = (Color32::from_rgb(90, 220, 120), Color32::from_gray(150));
    let times: [history::Series; 2] = [
        ("look", look, |frame| frame.look_ms),
        ("encode", encode, |frame| frame.encode_ms),
    ];
    history.plot(ui, &times, "ms");
    let counts: [[history::Series; 2]; 3] = [
        [
            ("items", visible, |frame| frame.items),
            ("in the frustum", others, |frame| frame.items_in_frustum),
        ],
        [
            ("triangles", visible, |frame| frame.triangles),
            ("in the frustum", others, |frame| frame.triangles_in_frustum),
        ],
        [
            ("draw calls", encode, |frame| frame.draw_calls),
            ("passages", look, |frame| frame.passages),
        ],
    ];
    for series in counts {
        history.plot(ui, &series, "");
    }
}
