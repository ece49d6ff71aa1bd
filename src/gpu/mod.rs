//! The graphics device and the few tools that every pass is made of.
//!
//! Nothing here knows of scenes or glass: [`device`] opens an adapter, [`shader`] resolves includes and reflects,
//! [`layout`] checks that host and shader structs agree, [`pass`] makes pipelines whose resources are bound by name,
//! [`recorder`] records stages and times them ([`clock`] by the device's timestamps), [`buffer`] makes, fills and reads
//! buffers and textures.

pub mod buffer;
pub mod clock;
pub mod device;
pub mod layout;
pub mod pass;
pub mod recorder;
pub mod shader;

pub use device::{AdapterChoice, Gpu};
pub use layout::{GpuStruct, Layout};
pub use pass::ComputePass;
pub use recorder::{Recorder, StageTimes, Timing};

/// What can go wrong between the program and the graphics device.
#[derive(Debug, thiserror::Error)]
pub enum GpuError {
    /// No usable adapter.
    #[error(
        "no Vulkan, Metal or Direct3D 12 adapter: {0}; install a driver (on Debian: apt install mesa-vulkan-drivers libvulkan1)"
    )]
    NoAdapter(String),
    /// The adapter refused a device.
    #[error("the adapter `{adapter}` refused a device: {reason}; `murrine doctor` lists what is needed")]
    NoDevice {
        /// The adapter's name.
        adapter: String,
        /// What the driver said.
        reason: String,
    },
    /// A shader did not resolve, parse, validate or compile. The text starts with `file:line:column`.
    #[error("{0}")]
    Shader(String),
    /// A limit of the adapter is too small for what was asked.
    #[error("{what} needs {needed} bytes, the adapter allows {allowed}; {remedy}")]
    Limit {
        /// What was to be made.
        what: String,
        /// Bytes needed.
        needed: u64,
        /// Bytes allowed.
        allowed: u64,
        /// What the user can do.
        remedy: &'static str,
    },
    /// The adapter has no room left.
    #[error("{what} did not fit in the adapter's memory; {remedy}")]
    Memory {
        /// What was to be made.
        what: String,
        /// What the user can do.
        remedy: &'static str,
    },
    /// More of something than there are numbers for.
    #[error("{needed} {what}, at most {allowed} can be shown; {remedy}")]
    TooMany {
        /// What there is too much of.
        what: String,
        /// How many.
        needed: u64,
        /// How many are allowed.
        allowed: u64,
        /// What the user can do.
        remedy: &'static str,
    },
    /// A method of this name does not exist.
    #[error("unknown {what} `{name}`; choose one of {known}")]
    Unknown {
        /// What kind of method.
        what: &'static str,
        /// The name that was asked for.
        name: String,
        /// Those there are.
        known: String,
    },
    /// A setting that this method or this adapter can't take.
    #[error("{0}")]
    Setting(String),
    /// The device was lost or a read-back failed.
    #[error("the graphics device stopped answering: {0}")]
    Lost(String),
}
