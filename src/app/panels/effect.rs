//! How the volume is lit.

use super::rows::{angle, choice, log_slider, tick, whole_slider};
use crate::app::session::Session;
use crate::scene::description::{Hit, Refraction};
use egui::Ui;

/// Refraction, transmittance, shadow, exposure.
pub(super) fn show(ui: &mut Ui, session: &mut Session) {
    let effect = &mut session.scene.effect;
    choice(ui, "Refraction", "how rays bend", &mut effect.refraction);
    choice(ui, "Hit", "how a ray meets the volume", &mut effect.hit);
    if effect.hit == Hit::Voxel {
        let hint = "a second refraction within this angle of the last normal is ignored";
        angle(ui, "Threshold", hint, &mut effect.angle_threshold_deg, 0.0..=90.0);
    }
    if effect.refraction == Refraction::MultipleSurface {
        let hint = "the most refractions and inner reflections along one ray";
        whole_slider(ui, "Most events", hint, &mut effect.max_events, 1..=32);
    }
    tick(ui, "Transmittance", "absorption along the view ray", &mut effect.transmittance);
    tick(ui, "Reflection", "of the surroundings at the first surface", &mut effect.reflection);
    choice(ui, "Shadow", "how glass dims the light behind it", &mut effect.shadow);
    let hint = "rays that met a leak take the colour of their good neighbours";
    tick(ui, "Mend rays", hint, &mut effect.fill_questionable);
    log_slider(ui, "Exposure", "scales the light before the tone map", &mut effect.exposure, 0.05..=20.0);
}
