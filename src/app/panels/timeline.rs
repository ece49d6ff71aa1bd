//! The bar of time below the picture.

use super::icons::{self, Icon};
use super::rows::plain;
use super::{Command, Stage};
use crate::app::actions::{ActionId, hint};
use egui::{RichText, Ui};

/// Play, pause, scrub.
pub(super) fn show(ui: &mut Ui, stage: &mut Stage<'_>) {
    ui.add_space(3.0);
    ui.horizontal(|ui| {
        let playing = stage.session.timeline.playing;
        for (icon, action) in
            [(Icon::ToStart, ActionId::Rewind), (if playing { Icon::Pause } else { Icon::Play }, ActionId::PlayPause)]
        {
            if icons::button(ui, icon, true, &hint(action)).clicked() {
                stage.commands.push(Command::Act(action));
            }
        }
        let timeline = &mut stage.session.timeline;
        let mut phase = timeline.phase_secs();
        let duration = timeline.duration_secs;
        let label = RichText::new(format!("{phase:6.2} / {duration:.2} s")).monospace().weak();
        ui.spacing_mut().slider_width = (ui.available_width() - 130.0).max(40.0);
        let slider = ui.add(plain(&mut phase, 0.0..=duration).show_value(false));
        if slider.dragged() || slider.changed() {
            timeline.playing = false;
            timeline.time_secs = phase;
        }
        ui.label(label);
    });
    ui.add_space(1.0);
}
