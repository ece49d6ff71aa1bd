//! Pipelines whose resources are bound by name.
//!
//! A pass has one name: `src/march.rs`, `shaders/march.wgsl`, label `march`. Names, binding numbers and workgroup
//! sizes come from the shader by reflection; a resource that is missing is a bug and panics with both names.

use super::{Gpu, GpuError, Layout, layout, shader::Shader};
use wgpu::naga;

/// One compute entry point.
#[derive(Debug)]
pub struct ComputePass {
    label: String,
    pipeline: wgpu::ComputePipeline,
    bindings: Bindings,
    workgroup_size: [u32; 3],
}

/// Passes that are compiled when they are first asked for: code that a scene has no use for costs its time on devices
/// that run branches as masks, so a shader is compiled for what it is to do.
#[derive(Debug)]
pub struct Variants<K> {
    made: Vec<(K, ComputePass)>,
}

/// The resources that an entry point uses, by name.
#[derive(Debug)]
pub struct Bindings {
    label: String,
    used: Vec<(String, u32)>,
    known: Vec<String>,
}

impl ComputePass {
    /// Compiles entry point `entry` of `shader`. `layouts` are the host structs it shares; each is checked.
    ///
    /// # Errors
    /// When the shader is wrong or a struct disagrees.
    pub fn new(gpu: &Gpu, shader: &str, entry: &str, layouts: &[Layout]) -> Result<Self, GpuError> {
        Self::with_constants(gpu, shader, entry, layouts, &[])
    }

    /// As [`ComputePass::new`], with values for the shader's `override`s.
    ///
    /// # Errors
    /// When the shader is wrong or a struct disagrees.
    pub fn with_constants(
        gpu: &Gpu,
        shader: &str,
        entry: &str,
        layouts: &[Layout],
        constants: &[(&str, f64)],
    ) -> Result<Self, GpuError> {
        let source = gpu.shaders.load(shader)?;
        for each in layouts {
            layout::check(&source.module, shader, each)?;
        }
        let label = label_of(shader, entry);
        let bindings = Bindings::of(&source, &label, &[entry])?;
        let point = source.module.entry_points.iter().find(|e| e.name == entry);
        let workgroup_size = point.map_or([1, 1, 1], |e| e.workgroup_size);
        let pipeline = guarded(gpu, shader, || {
            let module = module_of(gpu, &source);
            gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(&label),
                layout: None,
                module: &module,
                entry_point: Some(entry),
                compilation_options: wgpu::PipelineCompilationOptions { constants, ..Default::default() },
                cache: None,
            })
        })?;
        Ok(Self { label, pipeline, bindings, workgroup_size })
    }

    /// Binds resources by the names of the shader's globals. Names that this entry point does not use are left out.
    ///
    /// # Panics
    /// When a resource that the entry point uses is missing, or a name is unknown to the shader.
    #[must_use]
    pub fn bind(&self, gpu: &Gpu, resources: &[(&str, wgpu::BindingResource<'_>)]) -> wgpu::BindGroup {
        self.bindings.group(gpu, &self.pipeline.get_bind_group_layout(0), resources)
    }

    /// Binds what this entry point uses out of `resources`, which may hold more than its shader knows: for passes that
    /// share a set.
    ///
    /// # Panics
    /// When a resource that the entry point uses is missing.
    #[must_use]
    pub fn bind_used(&self, gpu: &Gpu, resources: &[(&str, wgpu::BindingResource<'_>)]) -> wgpu::BindGroup {
        let known: Vec<_> = resources.iter().filter(|(name, _)| self.bindings.knows(name)).cloned().collect();
        self.bind(gpu, &known)
    }

    /// Dispatches at least `threads` threads, rounded up to whole workgroups, as a 2D dispatch if one row is too short:
    /// shaders of one-dimensional work find their index with `thread_index` of `lib/dispatch.inc.wgsl`.
    pub fn dispatch(&self, encoder: &mut wgpu::CommandEncoder, group: &wgpu::BindGroup, threads: [u32; 3]) {
        let mut groups = [0, 1, 2].map(|i| threads[i].div_ceil(self.workgroup_size[i]));
        if groups.contains(&0) {
            return;
        }
        if groups[0] > 65_535 && groups[1] == 1 {
            groups[1] = groups[0].div_ceil(65_535);
            groups[0] = groups[0].div_ceil(groups[1]);
        }
        let mut pass = encoder
            .begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some(&self.label), timestamp_writes: None });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, group, &[]);
        pass.dispatch_workgroups(groups[0], groups[1], groups[2]);
    }

    /// Dispatches as many workgroups as three `u32` at `offset` of `arguments` say.
    pub fn dispatch_indirect(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        group: &wgpu::BindGroup,
        arguments: &wgpu::Buffer,
        offset: u64,
    ) {
        let mut pass = encoder
            .begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some(&self.label), timestamp_writes: None });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, group, &[]);
        pass.dispatch_workgroups_indirect(arguments, offset);
    }

    /// The workgroup size that the shader declares.
    #[must_use]
    pub fn workgroup_size(&self) -> [u32; 3] {
        self.workgroup_size
    }
}

impl<K: PartialEq> Variants<K> {
    /// None yet.
    #[must_use]
    pub fn new() -> Self {
        Self { made: Vec::new() }
    }

    /// The pass for `key`; `make` compiles it if there is none.
    ///
    /// # Errors
    /// Those of `make`.
    pub fn pass(
        &mut self,
        key: K,
        make: impl FnOnce(&K) -> Result<ComputePass, GpuError>,
    ) -> Result<&ComputePass, GpuError> {
        let found = match self.made.iter().position(|(made_for, _)| *made_for == key) {
            Some(found) => found,
            None => {
                let pass = make(&key)?;
                self.made.push((key, pass));
                self.made.len() - 1
            }
        };
        Ok(&self.made[found].1)
    }
}

impl<K: PartialEq> Default for Variants<K> {
    fn default() -> Self {
        Self::new()
    }
}

impl Bindings {
    /// The union of what the entry points use.
    ///
    /// # Errors
    /// When the shader has no such entry point.
    pub fn of(shader: &Shader, label: &str, entries: &[&str]) -> Result<Self, GpuError> {
        let module = &shader.module;
        let mut used = Vec::new();
        let mut known = Vec::new();
        for entry in entries {
            let index = module.entry_points.iter().position(|e| e.name == *entry).ok_or_else(|| {
                GpuError::Shader(format!("shaders/{}: there is no entry point `{entry}`", shader.name))
            })?;
            let info = shader.info.get_entry_point(index);
            for (handle, global) in module.global_variables.iter() {
                let (Some(name), Some(binding)) = (global.name.clone(), global.binding) else { continue };
                if !info[handle].is_empty() && !used.contains(&(name.clone(), binding.binding)) {
                    used.push((name.clone(), binding.binding));
                }
                if !known.contains(&name) {
                    known.push(name);
                }
            }
        }
        Ok(Self { label: label.to_owned(), used, known })
    }

    /// True for the name of a resource of the shader.
    #[must_use]
    pub fn knows(&self, name: &str) -> bool {
        self.known.iter().any(|k| k == name)
    }

    /// Makes the bind group 0.
    ///
    /// # Panics
    /// When a resource that is used is missing, or a name is unknown to the shader.
    #[must_use]
    pub fn group(
        &self,
        gpu: &Gpu,
        layout: &wgpu::BindGroupLayout,
        resources: &[(&str, wgpu::BindingResource<'_>)],
    ) -> wgpu::BindGroup {
        for (name, _) in resources {
            assert!(self.knows(name), "pass `{}` has no resource `{name}`", self.label);
        }
        let given = |name: &str| resources.iter().find(|(given, _)| *given == name);
        let missing = self.used.iter().find(|(name, _)| given(name).is_none());
        assert!(missing.is_none(), "pass `{}` needs the resource {missing:?}", self.label);
        let entries: Vec<_> = (self.used.iter())
            .filter_map(|(name, binding)| Some((given(name)?, *binding)))
            .map(|((_, resource), binding)| wgpu::BindGroupEntry { binding, resource: resource.clone() })
            .collect();
        gpu.device.create_bind_group(&wgpu::BindGroupDescriptor { label: Some(&self.label), layout, entries: &entries })
    }
}

/// Compiles the joined text of `shader`.
#[must_use]
pub fn module_of(gpu: &Gpu, shader: &Shader) -> wgpu::ShaderModule {
    gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(&shader.name),
        source: wgpu::ShaderSource::Wgsl(shader.source.as_str().into()),
    })
}

/// Runs `make` and turns the device's complaints into an error that names the shader.
///
/// # Errors
/// What the device said.
pub fn guarded<T>(gpu: &Gpu, shader: &str, make: impl FnOnce() -> T) -> Result<T, GpuError> {
    let scope = gpu.device.push_error_scope(wgpu::ErrorFilter::Validation);
    let made = make();
    match pollster::block_on(scope.pop()) {
        None => Ok(made),
        Some(error) => Err(GpuError::Shader(format!("shaders/{shader}: {error}"))),
    }
}

fn label_of(shader: &str, entry: &str) -> String {
    let stem = shader.trim_end_matches(".wgsl");
    if entry == "main" { stem.to_owned() } else { format!("{stem} {entry}") }
}

/// True for a binding that naga sees written.
#[must_use]
pub fn is_written(info: naga::valid::GlobalUse) -> bool {
    info.contains(naga::valid::GlobalUse::WRITE)
}
