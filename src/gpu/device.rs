//! Opens an adapter and a device.

use super::{GpuError, clock::StageClock, shader::ShaderLibrary};

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
        let info = adapter.get_info();
        let have = adapter.limits();
        let limits = wgpu::Limits {
            max_storage_buffer_binding_size: have.max_storage_buffer_binding_size,
            max_buffer_size: have.max_buffer_size,
            max_texture_dimension_2d: have.max_texture_dimension_2d,
            ..wgpu::Limits::default()
        };
        let wanted = wgpu::Features::TIMESTAMP_QUERY | wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS;
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("murrine"),
            required_features: adapter.features() & wanted,
            required_limits: limits,
            memory_hints: wgpu::MemoryHints::Performance,
            ..Default::default()
        }))
        .map_err(|e| GpuError::NoDevice { adapter: info.name.clone(), reason: e.to_string() })?;
        Ok(Self { device, queue, adapter, info, shaders: ShaderLibrary::default(), clock: StageClock::default() })
    }

    /// True on a software adapter, where the golden frames are made.
    #[must_use]
    pub fn is_software(&self) -> bool {
        self.info.device_type == wgpu::DeviceType::Cpu
    }
}
