//! Host structs whose layout is *checked* against the shader's, by field name, offset and size.

use super::GpuError;
use wgpu::naga;

/// Name, fields and size of a host struct.
#[derive(Debug, Clone, Copy)]
pub struct Layout {
    /// The struct's name, the same on both sides.
    pub name: &'static str,
    /// Name, offset and size in bytes of each field. Names that start with `_` are padding and not looked for.
    pub fields: &'static [(&'static str, usize, usize)],
    /// Size in bytes: the array stride on both sides.
    pub size: usize,
}

/// A struct shared with shaders. Made by [`gpu_struct!`](crate::gpu_struct).
pub trait GpuStruct: bytemuck::Pod {
    /// The layout as the host compiler made it.
    const LAYOUT: Layout;
}

/// Declares a `#[repr(C)]` struct that is shared with shaders, and its [`Layout`].
#[macro_export]
macro_rules! gpu_struct {
    ($(#[$meta:meta])* $outer:vis struct $name:ident { $($(#[$field_meta:meta])* $vis:vis $field:ident : $ty:ty,)* }) => {
        $(#[$meta])*
        #[repr(C)]
        #[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
        $outer struct $name { $($(#[$field_meta])* $vis $field: $ty,)* }
        impl $crate::gpu::GpuStruct for $name {
            const LAYOUT: $crate::gpu::Layout = $crate::gpu::Layout {
                name: stringify!($name),
                fields: &[$((stringify!($field), std::mem::offset_of!($name, $field), size_of::<$ty>()),)*],
                size: size_of::<$name>(),
            };
        }
    };
}

/// Compares `layout` with the struct of the same name in `module`; a module without one passes.
///
/// # Errors
/// Names the struct, the field and both figures.
pub fn check(module: &naga::Module, shader: &str, layout: &Layout) -> Result<(), GpuError> {
    let Some((_, ty)) = module.types.iter().find(|(_, t)| t.name.as_deref() == Some(layout.name)) else {
        return Ok(());
    };
    let naga::TypeInner::Struct { members, span } = &ty.inner else {
        return Err(GpuError::Shader(format!(
            "{shader}: `{}` is a struct on the host and is not one here",
            layout.name
        )));
    };
    let sizes = {
        let mut layouter = naga::proc::Layouter::default();
        layouter.update(module.to_ctx()).map_err(|e| GpuError::Shader(format!("{shader}: {e}")))?;
        layouter
    };
    let host: Vec<_> = layout.fields.iter().filter(|(name, ..)| !name.starts_with('_')).collect();
    let here: Vec<_> = members.iter().filter(|m| !m.name.as_deref().unwrap_or("_").starts_with('_')).collect();
    let fault = |what: String| Err(GpuError::Shader(format!("{shader}: struct `{}`: {what}", layout.name)));
    if host.len() != here.len() {
        return fault(format!("{} fields here, {} on the host", here.len(), host.len()));
    }
    for ((name, offset, size), member) in host.into_iter().zip(here) {
        let shader_name = member.name.as_deref().unwrap_or("");
        if *name != shader_name {
            return fault(format!("field `{shader_name}` here is `{name}` on the host"));
        }
        if *offset != member.offset as usize {
            return fault(format!("field `{name}` is at {} here, at {offset} on the host", member.offset));
        }
        let shader_size = sizes[member.ty].size as usize;
        if *size != shader_size {
            return fault(format!("field `{name}` has {shader_size} bytes here, {size} on the host"));
        }
    }
    if layout.size != *span as usize {
        return fault(format!("{span} bytes here, {} on the host", layout.size));
    }
    Ok(())
}
