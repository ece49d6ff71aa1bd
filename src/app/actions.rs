//! The one table of what the window can be told to do: it feeds the menu, the keys, the help and the clicker.

use super::view::Mode;
use egui::Key;

/// What an action does; the shell carries it out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ActionId {
    /// Plays or pauses.
    PlayPause,
    /// A step back in time.
    StepBack,
    /// A step forward in time.
    StepForward,
    /// Back to the start.
    Rewind,
    /// Moves the camera so that everything is in the picture.
    FrameAll,
    /// The camera as the file has it.
    ResetCamera,
    /// Shows something else.
    Show(Mode),
    /// The scene after this one in its folder.
    NextScene,
    /// The scene before this one in its folder.
    PreviousScene,
    /// Reads the scene again.
    Reload,
    /// Writes the scene.
    Save,
    /// Takes the last edit back.
    Undo,
    /// Makes it again.
    Redo,
    /// The scene as the file has it.
    ResetScene,
    /// Writes the picture.
    Screenshot,
    /// Shows or hides the panels.
    Panels,
    /// The window fills the screen, or not.
    FullScreen,
    /// Larger text and controls.
    LargerText,
    /// Smaller text and controls.
    SmallerText,
    /// Shows or hides the help.
    Help,
    /// Closes the help, else leaves full screen; never the program.
    Leave,
}

/// Where an action stands in the menu and in the help.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Group {
    /// Time.
    Time,
    /// Camera.
    Camera,
    /// Scene files and edits.
    Scene,
    /// What is shown.
    Show,
    /// The window itself.
    Window,
}

impl Group {
    /// All groups, in the order shown, with their titles.
    pub const ALL: &'static [(Group, &'static str)] = &[
        (Group::Scene, "Scene"),
        (Group::Time, "Time"),
        (Group::Camera, "Camera"),
        (Group::Show, "Show"),
        (Group::Window, "Window"),
    ];
}

/// A key with its modifiers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Chord {
    /// The key.
    pub key: Key,
    /// Ctrl (on a Mac: Cmd).
    pub ctrl: bool,
    /// Shift; `None` where a layout may need it to type the sign at all.
    pub shift: Option<bool>,
}

impl Chord {
    /// True for this key with these modifiers.
    #[must_use]
    pub fn matches(&self, key: Key, modifiers: egui::Modifiers) -> bool {
        self.key == key
            && self.ctrl == modifiers.command
            && !modifiers.alt
            && self.shift.is_none_or(|shift| shift == modifiers.shift)
    }

    /// True where one key press could mean both.
    #[must_use]
    pub fn collides(&self, other: &Self) -> bool {
        self.key == other.key
            && self.ctrl == other.ctrl
            && (self.shift == other.shift || self.shift.is_none() || other.shift.is_none())
    }

    /// As the help writes it, such as `Ctrl+Shift+Z`.
    #[must_use]
    pub fn text(&self) -> String {
        let mut text = String::new();
        if self.ctrl {
            text.push_str("Ctrl+");
        }
        if self.shift == Some(true) {
            text.push_str("Shift+");
        }
        text.push_str(match self.key {
            Key::Period => ".",
            Key::Questionmark => "?",
            Key::Plus => "+",
            Key::Equals => "=",
            Key::Minus => "-",
            Key::ArrowLeft => "Left",
            Key::ArrowRight => "Right",
            Key::Escape => "Esc",
            key => key.name(),
        });
        text
    }
}

/// A line of the table.
#[derive(Debug)]
pub struct Action {
    /// What it does.
    pub id: ActionId,
    /// Its name in the menu.
    pub name: &'static str,
    /// What the help says beyond the name.
    pub help: &'static str,
    /// Its keys, the first one shown in the menu.
    pub keys: &'static [Chord],
    /// Where it stands.
    pub group: Group,
}

const fn plain(key: Key) -> Chord {
    Chord { key, ctrl: false, shift: Some(false) }
}

const fn sign(key: Key) -> Chord {
    Chord { key, ctrl: false, shift: None }
}

const fn ctrl(key: Key) -> Chord {
    Chord { key, ctrl: true, shift: Some(false) }
}

const fn ctrl_sign(key: Key) -> Chord {
    Chord { key, ctrl: true, shift: None }
}

const fn ctrl_shift(key: Key) -> Chord {
    Chord { key, ctrl: true, shift: Some(true) }
}

const fn action(id: ActionId, name: &'static str, group: Group, keys: &'static [Chord], help: &'static str) -> Action {
    Action { id, name, help, keys, group }
}

const fn show(mode: Mode, name: &'static str, keys: &'static [Chord], help: &'static str) -> Action {
    action(ActionId::Show(mode), name, Group::Show, keys, help)
}

/// Every action.
#[rustfmt::skip]
pub const ACTIONS: &[Action] = &[
    action(ActionId::NextScene, "Next scene", Group::Scene, &[plain(Key::PageDown)], "in the scene's folder"),
    action(ActionId::PreviousScene, "Previous scene", Group::Scene, &[plain(Key::PageUp)], "in the scene's folder"),
    action(ActionId::Reload, "Reload", Group::Scene, &[plain(Key::F5)], "reads the scene and its models again"),
    action(ActionId::Save, "Save scene", Group::Scene, &[ctrl(Key::S)], "into its file; a model alone is saved beside itself"),
    action(ActionId::Undo, "Undo", Group::Scene, &[ctrl(Key::Z)], "takes the last edit back (not camera moves)"),
    action(ActionId::Redo, "Redo", Group::Scene, &[ctrl_shift(Key::Z), ctrl(Key::Y)], "makes it again"),
    action(ActionId::ResetScene, "Reset scene", Group::Scene, &[ctrl(Key::R)], "as the file has it"),
    action(ActionId::PlayPause, "Play or pause", Group::Time, &[plain(Key::Space)], ""),
    action(ActionId::StepBack, "Step back", Group::Time, &[plain(Key::ArrowLeft)], "hold to scrub"),
    action(ActionId::StepForward, "Step forward", Group::Time, &[plain(Key::ArrowRight)], "hold to scrub"),
    action(ActionId::Rewind, "To the start", Group::Time, &[plain(Key::Home)], ""),
    action(ActionId::FrameAll, "Frame", Group::Camera, &[sign(Key::Period)], "brings every model into the picture"),
    action(ActionId::ResetCamera, "Reset camera", Group::Camera, &[plain(Key::R)], "as the file has it"),
    show(Mode::Picture, "Picture", &[sign(Key::Num1)], ""),
    show(Mode::Cubes, "Voxels", &[sign(Key::Num2)], "the view grid's voxels as cubes"),
    show(Mode::Classes, "Small and large", &[sign(Key::Num0)], "voxels by the way their triangle was marked: amber by a thread, blue by fragments"),
    show(Mode::Slice, "Slice", &[sign(Key::Num3)], "one slice of the view grid"),
    show(Mode::Normals, "Normals", &[sign(Key::Num4)], "of the first surface"),
    show(Mode::Thickness, "Thickness", &[sign(Key::Num5)], "length inside glass"),
    show(Mode::Events, "Refractions", &[sign(Key::Num6)], "refractions and inner reflections along each ray"),
    show(Mode::Questionable, "Questionable rays", &[sign(Key::Num7)], "rays that met a leak"),
    show(Mode::LightVolume, "Light volume", &[sign(Key::Num8)], "light that is left, one slice of light 0's grid"),
    show(Mode::Transmittance, "Transmittance", &[sign(Key::Num9)], "absorption alone"),
    action(ActionId::Screenshot, "Screenshot", Group::Window, &[plain(Key::F12)], "a PNG at full resolution, named by scene and number"),
    action(ActionId::Panels, "Panels", Group::Window, &[plain(Key::Tab)], "shows or hides them"),
    action(ActionId::FullScreen, "Full screen", Group::Window, &[plain(Key::F11)], ""),
    action(ActionId::LargerText, "Larger text", Group::Window, &[ctrl_sign(Key::Plus), ctrl_sign(Key::Equals)], ""),
    action(ActionId::SmallerText, "Smaller text", Group::Window, &[ctrl_sign(Key::Minus)], ""),
    action(ActionId::Help, "Help", Group::Window, &[plain(Key::H), sign(Key::Questionmark), plain(Key::F1)], "these keys"),
    action(ActionId::Leave, "Leave", Group::Window, &[plain(Key::Escape)], "closes what is open, then full screen; never the program"),
];

/// What the mouse does, for the help.
pub const GESTURES: &[(&str, &str)] = &[
    ("Left drag", "orbit"),
    ("Shift+left or middle drag", "pan"),
    ("Wheel or pinch", "zoom"),
    ("Drop a .toml, .glb, .gltf or .npz file", "opens it"),
    ("Drop a .hdr or .exr file", "lights the scene by it"),
];

/// Keys that presenters' clickers send.
pub const CLICKER_KEYS: &[Key] = &[Key::PageUp, Key::PageDown, Key::F5, Key::Escape, Key::Period];

/// The action that a key press means.
#[must_use]
pub fn of_key(key: Key, modifiers: egui::Modifiers) -> Option<ActionId> {
    ACTIONS.iter().find(|a| a.keys.iter().any(|c| c.matches(key, modifiers))).map(|a| a.id)
}

/// True for actions that a held key repeats.
#[must_use]
pub fn repeats(id: ActionId) -> bool {
    use ActionId::{LargerText, NextScene, PreviousScene, Redo, SmallerText, StepBack, StepForward, Undo};
    matches!(id, StepBack | StepForward | NextScene | PreviousScene | Undo | Redo | LargerText | SmallerText)
}

/// The line of an action.
#[must_use]
pub fn action_of(id: ActionId) -> Option<&'static Action> {
    ACTIONS.iter().find(|a| a.id == id)
}

/// Name and key of an action, as a hover text has them: `Undo (Ctrl+Z)`.
#[must_use]
pub fn hint(id: ActionId) -> String {
    match action_of(id) {
        Some(Action { name, keys: [first, ..], .. }) => format!("{name} ({})", first.text()),
        Some(Action { name, .. }) => (*name).to_owned(),
        None => String::new(),
    }
}

/// A line of the help: keys, name, what it does.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct HelpLine {
    /// `Ctrl+Shift+Z, Ctrl+Y`.
    pub keys: String,
    /// The action's name.
    pub name: &'static str,
    /// What it does.
    pub help: &'static str,
}

/// The help's lines of one group.
#[must_use]
pub fn help_lines(group: Group) -> Vec<HelpLine> {
    let keys = |a: &Action| a.keys.iter().map(Chord::text).collect::<Vec<_>>().join(", ");
    let lines = ACTIONS.iter().filter(|a| a.group == group);
    lines.map(|a| HelpLine { keys: keys(a), name: a.name, help: a.help }).collect()
}
