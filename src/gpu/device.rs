//! Opens an adapter and a device.

use super::{GpuError, clock::StageClock, shader::ShaderLibrary};
use std::sync::{Arc, OnceLock};

/// Which adapter to open.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub enum AdapterChoice {
    /// The fastest one.
    #[default]
    Fastest,
    /// The software one (lavapipe), which the golden frames are made on.
    Software,
    /// The first whose name contains this text, ignoring case.
    Named(String),
}

/// An open device with its queue and the shader sources.
#[derive(Debug)]
pub struct Gpu {
    /// The device.
    pub device: wgpu::Device,
    /// Its only queue.
    pub queue: wgpu::Queue,
    /// The adapter it came from.
    pub adapter: wgpu::Adapter,
    /// Name, driver and kind of the adapter.
    pub info: wgpu::AdapterInfo,
    /// Shader sources.
    pub shaders: ShaderLibrary,
    /// Its timestamps.
    pub clock: StageClock,
    /// Why it was lost, once it was.
    lost: Arc<OnceLock<String>>,
}

impl Gpu {
    /// Opens the chosen adapter with portable limits where they suffice, and the adapter's own where it has more.
    ///
    /// # Errors
    /// When there is no adapter, or it refuses.
    pub fn open(choice: &AdapterChoice) -> Result<Self, GpuError> {
        let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
        descriptor.backends = wgpu::Backends::PRIMARY;
        let instance = wgpu::Instance::new(descriptor);
        let adapter = Self::pick(&instance, choice)?;
        Self::from_adapter(adapter)
    }

    /// Opens the chosen one of the adapters that can show pictures on `surface`.
    ///
    /// # Errors
    /// When there is none, or it refuses.
    pub fn open_for_surface(
        instance: &wgpu::Instance,
        choice: &AdapterChoice,
        surface: &wgpu::Surface<'_>,
    ) -> Result<Self, GpuError> {
        Self::from_adapter(Self::pick_where(instance, choice, |a| a.is_surface_supported(surface))?)
    }

    /// Finds the adapter that `choice` names, without opening it.
    ///
    /// # Errors
    /// When none matches; the error lists those there are.
    pub fn pick(instance: &wgpu::Instance, choice: &AdapterChoice) -> Result<wgpu::Adapter, GpuError> {
        Self::pick_where(instance, choice, |_| true)
    }

    fn pick_where(
        instance: &wgpu::Instance,
        choice: &AdapterChoice,
        fits: impl Fn(&wgpu::Adapter) -> bool,
    ) -> Result<wgpu::Adapter, GpuError> {
        let mut adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::PRIMARY));
        adapters.retain(fits);
        let rank = |info: &wgpu::AdapterInfo| match info.device_type {
            wgpu::DeviceType::DiscreteGpu => 0,
            wgpu::DeviceType::IntegratedGpu => 1,
            wgpu::DeviceType::VirtualGpu => 2,
            wgpu::DeviceType::Other => 3,
            wgpu::DeviceType::Cpu => 4,
        };
        let names: Vec<String> = adapters.iter().map(|a| a.get_info().name).collect();
        let found = match choice {
            AdapterChoice::Fastest => adapters.into_iter().min_by_key(|a| rank(&a.get_info())),
            AdapterChoice::Software => adapters.into_iter().find(|a| a.get_info().device_type == wgpu::DeviceType::Cpu),
            AdapterChoice::Named(name) => {
                let wanted = name.to_lowercase();
                adapters.into_iter().find(|a| a.get_info().name.to_lowercase().contains(&wanted))
            }
        };
        found.ok_or_else(|| {
            GpuError::NoAdapter(if names.is_empty() {
                "none found".to_owned()
            } else {
                format!("none is {choice:?}, there are: {}", names.join(", "))
            })
        })
    }

    /// Opens a device on this adapter.
    ///
    /// # Errors
    /// When the adapter refuses.
    pub fn from_adapter(adapter: wgpu::Adapter) -> Result<Self, GpuError> {
        let have = adapter.limits();
        let limits = wgpu::Limits {
            max_storage_buffer_binding_size: have.max_storage_buffer_binding_size,
            max_buffer_size: have.max_buffer_size,
            max_texture_dimension_2d: have.max_texture_dimension_2d,
            ..wgpu::Limits::default()
        };
        let wanted = wgpu::Features::TIMESTAMP_QUERY
            | wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS
            | wgpu::Features::CONSERVATIVE_RASTERIZATION;
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("murrine"),
            required_features: adapter.features() & wanted,
            required_limits: limits,
            memory_hints: wgpu::MemoryHints::Performance,
            ..Default::default()
        }))
        .map_err(|e| GpuError::NoDevice { adapter: adapter.get_info().name, reason: e.to_string() })?;
        Ok(Self::new(adapter, device, queue))
    }

    /// A device that is open already.
    #[must_use]
    pub fn new(adapter: wgpu::Adapter, device: wgpu::Device, queue: wgpu::Queue) -> Self {
        let lost = Arc::new(OnceLock::new());
        let theirs = Arc::clone(&lost);
        device.set_device_lost_callback(move |reason, text| {
            // The first reason is the true one.
            let _ = theirs.set(format!("{reason:?} {text}").trim_end().to_lowercase());
        });
        let info = adapter.get_info();
        let (shaders, clock) = (ShaderLibrary::default(), StageClock::default());
        Self { device, queue, adapter, info, shaders, clock, lost }
    }

    /// The same device with other shaders, for a thread that compiles them.
    #[must_use]
    pub fn with_shaders(&self, shaders: ShaderLibrary) -> Self {
        Self {
            device: self.device.clone(),
            queue: self.queue.clone(),
            adapter: self.adapter.clone(),
            info: self.info.clone(),
            shaders,
            clock: StageClock::default(),
            lost: Arc::clone(&self.lost),
        }
    }

    /// Whether the device is still there. Only another one can go on once it is lost.
    ///
    /// # Errors
    /// [`GpuError::Lost`] with what the driver said.
    pub fn check(&self) -> Result<(), GpuError> {
        self.lost.get().map_or(Ok(()), |text| Err(GpuError::Lost(text.clone())))
    }

    /// True on a software adapter, where the golden frames are made.
    #[must_use]
    pub fn is_software(&self) -> bool {
        self.info.device_type == wgpu::DeviceType::Cpu
    }
}
