//! What the user should know: errors and warnings, each shown once until dismissed or mended.

/// What a notice is about. A new state of a topic replaces its old notices.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Topic {
    /// Reading the scene and its models.
    Scene,
    /// What is odd about the scene.
    SceneWarnings,
    /// What the frame could not do as asked.
    FrameWarnings,
    /// Rendering.
    Frame,
    /// Compiling shaders from their folder.
    Shaders,
    /// Writing files.
    Files,
    /// Watching files.
    Watch,
    /// The device.
    Device,
}

/// How bad it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Severity {
    /// Done as asked.
    Done,
    /// Odd, but shown.
    Warning,
    /// Not done; the last good state stays.
    Error,
}

/// A line of the strip.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Notice {
    /// About what.
    pub topic: Topic,
    /// How bad.
    pub severity: Severity,
    /// Place, what, remedy.
    pub text: String,
}

/// The strip.
#[derive(Debug, Default)]
pub struct Notices {
    shown: Vec<Notice>,
    dismissed: Vec<Notice>,
}

impl Notices {
    /// What is shown, oldest first.
    #[must_use]
    pub fn shown(&self) -> &[Notice] {
        &self.shown
    }

    /// Replaces the notices of a topic. One that was dismissed and still holds does not come back.
    pub fn set(&mut self, topic: Topic, severity: Severity, texts: impl IntoIterator<Item = String>) {
        let mut now: Vec<Notice> = Vec::new();
        for text in texts {
            let notice = Notice { topic, severity, text };
            if !now.contains(&notice) {
                now.push(notice);
            }
        }
        self.dismissed.retain(|n| n.topic != topic || now.contains(n));
        self.shown.retain(|n| n.topic != topic || now.contains(n));
        for notice in now {
            if !self.shown.contains(&notice) && !self.dismissed.contains(&notice) {
                self.shown.push(notice);
            }
        }
    }

    /// One notice of a topic, which comes back even when it was dismissed: the user has just asked for it.
    pub fn tell(&mut self, topic: Topic, severity: Severity, text: impl Into<String>) {
        self.clear(topic);
        self.set(topic, severity, [text.into()]);
    }

    /// The topic is mended.
    pub fn clear(&mut self, topic: Topic) {
        self.set(topic, Severity::Done, []);
    }

    /// Takes a line off the strip.
    pub fn dismiss(&mut self, index: usize) {
        if index < self.shown.len() {
            self.dismissed.push(self.shown.remove(index));
        }
    }
}
